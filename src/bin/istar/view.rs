//! `istar view`

use crate::archive::Archive;
use crate::pictures::RegionKind;
use crate::tell::tell;
use crate::{Outcome, encode, files, stream};
use axum::Router;
use axum::extract::Path as UrlPath;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use istar::container::Names;
use istar::{EncodeOptions, StreamOptions};
use rust_embed::RustEmbed;
use std::io::{Read, Write};
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use tower_http::services::{ServeDir, ServeFile};
use tower_http::set_header::SetResponseHeaderLayer;

/// Look at a picture in the browser
#[derive(clap::Args)]
pub struct Args {
    /// A PNG (encoded first), an .istar file, or a folder to serve as it is
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// What a region is, where a PNG is encoded
    #[arg(long, value_enum, default_value_t)]
    regions: RegionKind,
    /// Port to serve on; 0 takes a free one
    #[arg(long, value_name = "P", default_value_t = 8080)]
    port: u16,
}

/// The viewer page, as `npm run build` left it.
#[derive(RustEmbed)]
#[folder = "dist/"]
#[exclude = "gallery/*"]
#[exclude = "istar-material.js"]
#[exclude = "museum/*"]
#[exclude = "museum.html"]
// What only the npm package has.
#[exclude = "types/*"]
#[exclude = "custom-elements.json"]
#[exclude = "element.js"]
#[exclude = "index.js"]
#[exclude = "istar-inlined.js"]
#[exclude = "istar.classic.js"]
#[allow_missing = true]
struct Page;

pub fn run(args: &Args) -> Outcome {
    if args.input.is_dir() {
        return serve(Router::new().fallback_service(ServeDir::new(&args.input)), args.port);
    }
    if is_istar(&args.input)? {
        Archive::open(&args.input)?.check_length()?;
        return serve(one_picture(&args.input)?, args.port);
    }
    if args.regions != RegionKind::Antialiased && stream::is_large(&args.input, false) {
        let fault = |error| format!("cannot make a temporary folder: {error}");
        let folder = tempfile::tempdir().map_err(fault)?;
        let path = folder.path().join("picture.istar");
        let (options, names) = (StreamOptions::default(), Names::default());
        stream::encode(&args.input, &options, &names, files::Output::create(&path)?)?;
        return serve(one_picture(&path)?, args.port);
    }
    let encoded =
        encode::encode_file(&args.input, args.regions, &EncodeOptions::default(), None, None)?;
    let fault = |error| format!("cannot write a temporary file: {error}");
    let mut file = tempfile::NamedTempFile::new().map_err(fault)?;
    file.write_all(&encoded.bytes).map_err(fault)?;
    // Removed when the server ends and `file` goes out of scope.
    serve(one_picture(file.path())?, args.port)
}

fn is_istar(path: &Path) -> Result<bool, String> {
    let fault = |error| files::at(path, &files::reason(&error));
    let mut start = Vec::new();
    let magic = istar::container::MAGIC;
    let file = std::fs::File::open(path).map_err(fault)?;
    file.take(magic.len() as u64).read_to_end(&mut start).map_err(fault)?;
    Ok(start == magic)
}

/// The viewer's page around one picture.
fn one_picture(picture: &Path) -> Result<Router, String> {
    if Page::get("view.html").is_none() {
        return Err("this istar was built without the viewer page: run `npm run build`".into());
    }
    Ok(Router::new()
        .route_service("/picture.istar", ServeFile::new(picture))
        .route("/", get(|| async { page("view.html") }))
        .route("/{*path}", get(|UrlPath(path): UrlPath<String>| async move { page(&path) })))
}

fn page(path: &str) -> Response {
    let kind = match path.rsplit_once('.') {
        Some((_, "html")) => "text/html; charset=utf-8",
        Some((_, "js")) => "text/javascript",
        Some((_, "css")) => "text/css",
        // Browsers compile wasm while it arrives only under its own type.
        Some((_, "wasm")) => "application/wasm",
        Some((_, "svg")) => "image/svg+xml",
        _ => "application/octet-stream",
    };
    match Page::get(path) {
        Some(file) => ([(header::CONTENT_TYPE, kind)], file.data.into_owned()).into_response(),
        None => StatusCode::NOT_FOUND.into_response(),
    }
}

fn serve(app: Router, port: u16) -> Outcome {
    // What was encoded a moment ago must not come from the browser's cache.
    let fresh = SetResponseHeaderLayer::overriding(
        header::CACHE_CONTROL,
        HeaderValue::from_static("no-cache"),
    );
    let app = app.layer(fresh);
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|error| format!("cannot start the server: {error}"))?;
    runtime.block_on(async {
        let listener =
            tokio::net::TcpListener::bind((Ipv4Addr::LOCALHOST, port)).await.map_err(|error| {
                format!("cannot serve on port {port}: {error}: choose another with --port")
            })?;
        let address = listener.local_addr().map_err(|error| error.to_string())?;
        tell!("http://{address}/")?;
        axum::serve(listener, app)
            .with_graceful_shutdown(async {
                let _ = tokio::signal::ctrl_c().await;
            })
            .await
            .map_err(|error| format!("the server stopped: {error}"))
    })
}

//! Translates the shaders for WebGL2 and tells cargo what to watch.

#[cfg(feature = "gpu")]
mod needless;
#[cfg(feature = "gpu")]
mod paste;
#[cfg(feature = "gpu")]
mod shorten;
#[cfg(feature = "gpu")]
mod translate;

fn main() {
    println!("cargo::rerun-if-changed=shaders");
    // The command embeds the viewer page. Its files one by one: the gallery beside them is written
    // later, by the command itself, and a path that is missing would make cargo run this every time.
    for entry in std::fs::read_dir("dist").into_iter().flatten().flatten() {
        if entry.path().is_file() {
            println!("cargo::rerun-if-changed={}", entry.path().display());
        }
    }
    #[cfg(feature = "gpu")]
    if let Err(what) = write_shaders() {
        eprintln!("shaders: {what}");
        std::process::exit(1);
    }
}

/// Writes each module as `NAME.rs`, constants for the back ends, and its texts for the web as `NAME.js`, which a page
/// fetches apart from the WebAssembly module: each back end needs only its own. And `material.js`, for other programs.
#[cfg(feature = "gpu")]
fn write_shaders() -> Result<(), String> {
    use needless::without_needless;
    use shorten::{minify, shorten, shorten_values};
    use translate::{MODULES, TEXTURES, UNIFORMS, translate, validate};

    const WEB: &str = "#[cfg(target_arch = \"wasm32\")]\n";
    const NATIVE: &str = "#[cfg(not(target_arch = \"wasm32\"))]\n";

    let out = std::env::var_os("OUT_DIR").ok_or("cargo gave no OUT_DIR")?;
    let read = |files: &[&str]| -> Result<String, String> {
        let folder = std::path::Path::new("shaders");
        let text = |file: &&str| {
            std::fs::read_to_string(folder.join(file)).map_err(|e| format!("{file}: {e}"))
        };
        files.iter().map(text).collect()
    };
    let write = |name: &str, extension: &str, text: String| {
        let path = std::path::Path::new(&out).join(name).with_extension(extension);
        std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
    };
    let paste::Material { wgsl, glsl } = paste::material(&read(&paste::FILES)?)?;
    let texts = format!("export const wgsl = {wgsl:?};\nexport const glsl = {glsl:?};\n");
    write("material", "js", texts)?;
    for shaders in &MODULES {
        let wgsl = read(shaders.files)?;
        // Validated as written, so that an error shows the line and its comment.
        validate(&wgsl)?;
        let wgsl = shorten(&minify(&wgsl), &shaders.entry_points());
        let (module, _) = validate(&wgsl)?;
        let count = shaders.draws.len();
        let entry_points: Vec<_> =
            shaders.draws.iter().map(|draw| [draw.vertex, draw.fragment]).collect();
        let mut glsl = Vec::new();
        for draw in shaders.draws {
            let short = |text: String| without_needless(&shorten_values(&minify(&text)));
            glsl.push(translate(draw, &module)?.map(short));
        }
        let constants = format!(
            "{NATIVE}pub const WGSL: &str = {wgsl:?};\n\
             pub const ENTRY_POINTS: [[&str; 2]; {count}] = {entry_points:?};\n\
             {WEB}pub const GLSL_UNIFORMS: &str = {UNIFORMS:?};\n\
             {WEB}pub const GLSL_TEXTURES: [&str; {}] = {TEXTURES:?};\n",
            TEXTURES.len(),
        );
        // Of each draw the vertex shader and the fragment shader, each text once. Such texts are the same in both
        // languages: they are ASCII, and of what is escaped there are only ends of lines.
        let mut all: Vec<_> = glsl.iter().flatten().collect();
        all.sort();
        all.dedup();
        let number = |text| all.iter().position(|&other| other == text);
        let draws = glsl.iter().map(|stages| {
            let names: Vec<_> =
                stages.iter().filter_map(number).map(|i| format!("text{i}")).collect();
            format!("[{}]", names.join(", "))
        });
        let draws: Vec<_> = draws.collect();
        let mut texts = format!("export const wgsl = {wgsl:?};\n");
        for (i, text) in all.iter().enumerate() {
            texts += &format!("const text{i} = {text:?};\n");
        }
        texts += &format!("export const glsl = [{}];\n", draws.join(", "));
        write(shaders.name, "rs", constants)?;
        write(shaders.name, "js", texts)?;
    }
    Ok(())
}

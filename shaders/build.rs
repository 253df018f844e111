//! Translates the shaders for WebGL2 and tells cargo what to watch.

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

/// Writes each pass as `NAME.rs`: a module's constants with all that the back ends need.
#[cfg(feature = "gpu")]
fn write_shaders() -> Result<(), String> {
    use translate::{PASSES, minify, shorten, shorten_values, translate, validate};

    /// GLSL is for WebGL2 alone.
    const WEB: &str = "#[cfg(target_arch = \"wasm32\")]\n";

    let out = std::env::var_os("OUT_DIR").ok_or("cargo gave no OUT_DIR")?;
    for pass in &PASSES {
        let mut wgsl = String::new();
        for file in pass.files {
            let text = std::fs::read_to_string(std::path::Path::new("shaders").join(file));
            wgsl += &text.map_err(|e| format!("{file}: {e}"))?;
        }
        // Validated as written, so that an error shows the line and its comment.
        validate(&wgsl)?;
        let wgsl = shorten(&minify(&wgsl), &[pass.vertex, pass.fragment]);
        let (module, _) = validate(&wgsl)?;
        let glsl = translate(pass, &module)?;
        let constants = format!(
            "pub const WGSL: &str = {wgsl:?};\n\
             pub const VERTEX: &str = {:?};\n\
             pub const FRAGMENT: &str = {:?};\n\
             {WEB}pub const GLSL_VERTEX: &str = {:?};\n\
             {WEB}pub const GLSL_FRAGMENT: &str = {:?};\n\
             {WEB}pub const GLSL_UNIFORMS: &str = {:?};\n\
             {WEB}pub const GLSL_TEXTURES: [&str; {}] = {:?};\n",
            pass.vertex,
            pass.fragment,
            shorten_values(&minify(&glsl.vertex)),
            shorten_values(&minify(&glsl.fragment)),
            glsl.uniforms,
            glsl.textures.len(),
            glsl.textures,
        );
        let path = std::path::Path::new(&out).join(pass.name).with_extension("rs");
        std::fs::write(&path, constants).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}

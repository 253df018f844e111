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

/// Writes each module as `NAME.rs`: constants with all that the back ends need.
#[cfg(feature = "gpu")]
fn write_shaders() -> Result<(), String> {
    use translate::{
        MODULES, TEXTURES, UNIFORMS, minify, shorten, shorten_values, translate, validate,
    };

    /// GLSL is for WebGL2 alone.
    const WEB: &str = "#[cfg(target_arch = \"wasm32\")]\n";

    let out = std::env::var_os("OUT_DIR").ok_or("cargo gave no OUT_DIR")?;
    for shaders in &MODULES {
        let mut wgsl = String::new();
        for file in shaders.files {
            let text = std::fs::read_to_string(std::path::Path::new("shaders").join(file));
            wgsl += &text.map_err(|e| format!("{file}: {e}"))?;
        }
        // Validated as written, so that an error shows the line and its comment.
        validate(&wgsl)?;
        let wgsl = shorten(&minify(&wgsl), &shaders.entry_points());
        let (module, _) = validate(&wgsl)?;
        let count = shaders.draws.len();
        let entry_points: Vec<_> =
            shaders.draws.iter().map(|draw| [draw.vertex, draw.fragment]).collect();
        let mut glsl = Vec::new();
        for draw in shaders.draws {
            glsl.push(translate(draw, &module)?.map(|text| shorten_values(&minify(&text))));
        }
        // Of each draw the vertex shader and the fragment shader.
        let constants = format!(
            "pub const WGSL: &str = {wgsl:?};\n\
             pub const ENTRY_POINTS: [[&str; 2]; {count}] = {entry_points:?};\n\
             {WEB}pub const GLSL: [[&str; 2]; {count}] = {glsl:?};\n\
             {WEB}pub const GLSL_UNIFORMS: &str = {UNIFORMS:?};\n\
             {WEB}pub const GLSL_TEXTURES: [&str; {}] = {TEXTURES:?};\n",
            TEXTURES.len(),
        );
        let path = std::path::Path::new(&out).join(shaders.name).with_extension("rs");
        std::fs::write(&path, constants).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}

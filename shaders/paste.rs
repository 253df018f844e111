//! The material: functions that other programs paste into their own shaders, in WGSL and in GLSL ES 3.00, made of the
//! files that the viewer's shaders are made of. Shared by the build script and by `tests/suite/shaders.rs`.

use super::shorten::{self, tokens};
use super::translate::{self, validate};
use naga::ShaderStage;
use std::collections::BTreeSet;

/// What it is made of.
pub const FILES: [&str; 5] =
    ["common.wgsl", "decode.wgsl", "styles.wgsl", "seen.wgsl", "material.wgsl"];

/// What its files say otherwise there. Each is there once.
const INSTEAD: [(&str, &str); 3] = [
    // It has no uniforms: what these would say it says itself.
    ("@group(0) @binding(0) var<uniform> view: View;", "var<private> view: View;"),
    // A pixel is no square of the picture, but any parallelogram.
    ("gradient * per_cell", "(gradient * footprint) * per_cell"),
    ("bend * vec3(", "bent(bend) * vec3("),
];

/// The functions that programs call, and the entry point that is there for the translation alone.
const CALLED: [&str; 3] = ["istar_sample", "istar_sample_from", "istar_region"];
const ENTRY: &str = "paint_material";

/// What all names of the module begin with, so that none is the program's own.
const PREFIX: &str = "istar_";

/// The names of its textures, in the order of their bindings. The last has a sampler beside it.
pub const TEXTURES: [&str; 6] =
    ["istar_blocks", "istar_cells", "istar_cuts", "istar_styles", "istar_about", "istar_colors"];

/// What is said at the top of both texts.
const NOTICE: &str = "// IStar's material: MIT or Apache-2.0, as you like.\n";

/// Both texts.
pub struct Material {
    pub wgsl: String,
    pub glsl: String,
}

/// The material, of the text of its files.
pub fn material(files: &str) -> Result<Material, String> {
    let mut text = files.to_owned();
    for (one, other) in INSTEAD {
        if text.matches(one).count() != 1 {
            return Err(format!("the material's files do not have “{one}” once"));
        }
        text = text.replace(one, other);
    }
    validate(&text)?;
    let text = prefixed(&without_comments(&text));
    let entry = [PREFIX, ENTRY].concat();
    let all = needed(&text, &[&entry]);
    let (module, _) = validate(&all)?;
    let glsl =
        functions(&translate::stage_with(&module, ShaderStage::Fragment, &entry, &TEXTURES)?);
    let wgsl = needed(&text, &CALLED);
    validate(&wgsl)?;
    Ok(Material { wgsl: [NOTICE, &wgsl].concat(), glsl: [NOTICE, &glsl].concat() })
}

fn without_comments(text: &str) -> String {
    let mut kept = String::new();
    for line in text.lines() {
        let code = line.split("//").next().unwrap_or_default().trim_end();
        if !code.is_empty() {
            kept.push_str(code);
            kept.push('\n');
        }
    }
    kept
}

/// A declaration of the module with what is written before it, and its name.
fn declarations(text: &str) -> Vec<(&str, &str)> {
    let named = |declaration| {
        let mut tokens = tokens(declaration).into_iter().filter(|t| !t.trim().is_empty());
        let kind = tokens.by_ref().find(|t| ["fn", "struct", "const", "var"].contains(t));
        let mut depth = 0;
        // Of a variable its kind is said between.
        let name = tokens.find(|token| {
            depth += i32::from(*token == "<");
            let outside = depth == 0;
            depth -= i32::from(*token == ">");
            outside
        });
        kind.and(name).map(|name| (declaration, name))
    };
    shorten::declarations(text).filter_map(named).collect()
}

/// With the prefix before each name that the module declares, wherever it is used.
fn prefixed(text: &str) -> String {
    let names: BTreeSet<&str> = declarations(text)
        .into_iter()
        .map(|(_, name)| name)
        .filter(|name| !name.starts_with(PREFIX))
        .collect();
    let tokens = tokens(text);
    // Fields too that are called so: a name is the same everywhere.
    let renamed = tokens.iter().map(|token| match names.contains(token) {
        true => [PREFIX, token].concat(),
        false => (*token).to_owned(),
    });
    renamed.collect()
}

/// What some declarations need of a module, in its order, with these.
fn needed(text: &str, names: &[&str]) -> String {
    let all = declarations(text);
    let mut wanted: BTreeSet<&str> = names.iter().copied().collect();
    loop {
        let before = wanted.len();
        for (declaration, name) in &all {
            if wanted.contains(name) {
                wanted.extend(tokens(declaration));
            }
        }
        if wanted.len() == before {
            break;
        }
    }
    let kept = all.iter().filter(|(_, name)| wanted.contains(name));
    kept.map(|(declaration, _)| format!("{}\n", declaration.trim())).collect()
}

/// Of a fragment shader all but what a program has of its own: version and precision, what goes in and out, and `main`.
fn functions(glsl: &str) -> String {
    let own = ["#", "precision ", "layout(location", "smooth in", "flat in", "in "];
    let lines = glsl.lines().filter(|line| !own.iter().any(|start| line.starts_with(start)));
    let text: String = lines.map(|line| format!("{line}\n")).collect();
    let kept = shorten::declarations(&text).filter(|part| !part.contains("void main()"));
    kept.collect::<String>().lines().filter(|line| !line.is_empty()).fold(
        String::new(),
        |mut all, line| {
            all.push_str(line);
            all.push('\n');
            all
        },
    )
}

//! The shaders: joined from their files, validated, and translated to the GLSL ES 3.00 that
//! WebGL2 takes. Shared by the build script and by `tests/suite/shaders.rs`.

use naga::back::glsl;
use naga::compact::{KeepUnused, compact};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, GlobalVariable, Handle, Module, ShaderStage};
use std::collections::{BTreeMap, BTreeSet};

/// A module of shaders: its name, the files whose text makes it up, and its draws.
pub struct Shaders {
    pub name: &'static str,
    pub files: &'static [&'static str],
    pub draws: &'static [Draw],
}

/// The entry points of a draw.
pub struct Draw {
    pub vertex: &'static str,
    pub fragment: &'static str,
}

pub const MODULES: [Shaders; 1] = [Shaders {
    name: "picture",
    files: &["common.wgsl", "decode.wgsl", "styles.wgsl", "seen.wgsl", "picture.wgsl", "far.wgsl"],
    draws: &[
        Draw { vertex: "place_corner", fragment: "paint_one" },
        Draw { vertex: "place_corner", fragment: "paint_two" },
        Draw { vertex: "place_corner", fragment: "paint_rest" },
        Draw { vertex: "place_corner", fragment: "paint_styled" },
        Draw { vertex: "cover", fragment: "paint_far" },
    ],
}];

impl Shaders {
    /// Names that are not to change.
    pub fn entry_points(&self) -> Vec<&'static str> {
        self.draws.iter().flat_map(|draw| [draw.vertex, draw.fragment]).collect()
    }
}

/// What is bound, by the names that it has in all GLSL: the uniform block, and the textures in the order of their
/// bindings.
pub const UNIFORMS: &str = "_b";
pub const TEXTURES: [&str; 4] = ["_0", "_1", "_2", "_3"];

/// WGSL or GLSL without comments and most spaces: it travels inside the WebAssembly module.
pub fn minify(source: &str) -> String {
    // Beside these no space is needed; without the minus, since two of them are something else.
    let parts = |c: char| "(),;:{}=+*/<>&|?!^[]".contains(c);
    let mut short = String::new();
    for line in source.lines() {
        let code = line.split("//").next().unwrap_or_default().trim();
        if code.starts_with('#') {
            short.push_str(code);
            short.push('\n');
            continue;
        }
        let mut rest = code.chars().peekable();
        while let Some(c) = rest.next() {
            let next = rest.peek().copied();
            let is_needless =
                short.ends_with(|c: char| parts(c) || c.is_whitespace()) || next.is_some_and(parts);
            if c != ' ' || !is_needless {
                short.push(c);
            }
        }
        if !short.ends_with(parts) {
            short.push('\n');
        }
    }
    short
}

/// WGSL with one or two letters for each name that it declares, but for those to keep: names are a third of a
/// shader. A name is the same everywhere, so what shadowed another still does.
pub fn shorten(wgsl: &str, keep: &[&str]) -> String {
    const DECLARING: [&str; 5] = ["fn", "let", "var", "const", "struct"];
    let tokens = tokens(wgsl);
    let is_name = |token: &str| token.starts_with(|c: char| c.is_alphabetic() || c == '_');
    // The token before or after, spaces left out.
    let before = |i: usize| tokens[..i].iter().rev().find(|t| !t.trim().is_empty());
    let after = |i: usize| tokens[i + 1..].iter().find(|t| !t.trim().is_empty());
    let (mut counts, mut callable) = (BTreeMap::new(), BTreeSet::new());
    for (i, &token) in tokens.iter().enumerate() {
        let declaring = before(i).filter(|word| DECLARING.contains(word));
        if is_name(token) && (declaring.is_some() || after(i) == Some(&":")) {
            counts.insert(token, 0);
            if declaring.is_some_and(|word| ["fn", "struct"].contains(word)) {
                callable.insert(token);
            }
        }
    }
    // An attribute or its argument, or a component of a vector.
    let is_fixed = |i: usize| {
        let component = |c: char| "xyzwrgba".contains(c);
        let is_attribute = (i >= 1 && tokens[i - 1] == "@")
            || (i >= 3 && tokens[i - 1] == "(" && tokens[i - 3] == "@");
        is_attribute || (before(i) == Some(&".") && tokens[i].chars().all(component))
    };
    for (i, token) in tokens.iter().enumerate() {
        if after(i) == Some(&"(") && !callable.contains(token) {
            // Something built in has the name too.
            counts.remove(token);
        } else if !is_fixed(i) {
            counts.entry(token).and_modify(|count| *count += 1);
        }
    }
    for name in keep {
        counts.remove(name);
    }
    let short = short_names(counts, &tokens);
    let renamed = |(i, token): (usize, &&'_ str)| match short.get(token) {
        Some(name) if !is_fixed(i) => name.clone(),
        _ => token.to_string(),
    };
    tokens.iter().enumerate().map(renamed).collect()
}

/// GLSL in which a value that only the next statement has use for is worked out there. Naga gives each a name and a
/// statement of its own. Nothing comes between the two, and nothing in either changes what the other reads.
fn join_values(glsl: &str) -> String {
    let mut joined = String::new();
    for declaration in declarations(glsl) {
        let mut text = declaration.to_owned();
        while let Some(shorter) = join_value(&text) {
            text = shorter;
        }
        joined.push_str(&text);
    }
    joined
}

/// The same of one value, the first that there is.
fn join_value(function: &str) -> Option<String> {
    let tokens = tokens(function);
    let statements: Vec<usize> =
        (0..tokens.len()).filter(|&i| [";", "{", "}"].contains(&tokens[i])).collect();
    statements.windows(3).find_map(|ends| {
        let &[start, end, stop] = ends else { return None };
        let [_, " ", name, "=", value @ ..] = &tokens[start + 1..end] else { return None };
        // Not a field that is called so.
        let mut uses = (end..tokens.len()).filter(|&i| tokens[i] == *name && tokens[i - 1] != ".");
        let place = uses.next()?;
        // What the next statement begins with is set there.
        if tokens[end] != ";" || place == end + 1 || place > stop || uses.next().is_some() {
            return None;
        }
        let is_whole =
            value.first()?.starts_with(|c: char| c.is_alphanumeric() || "_(".contains(c));
        let [open, close] = if is_whole { ["", ""] } else { ["(", ")"] };
        let (before, after) = (&tokens[end + 1..place], &tokens[place + 1..]);
        let value = [open, &value.concat(), close].concat();
        Some([tokens[..=start].concat(), before.concat(), value, after.concat()].concat())
    })
}

/// GLSL with a letter or two for each of the values and names that naga has numbered, and without the constants that
/// it has put in their places. What is worked out for the next statement alone is part of it. Each function for itself,
/// so that one that is in several shaders is the same text in all, which packs to nothing.
pub fn shorten_values(glsl: &str) -> String {
    let glsl = join_values(glsl);
    let all = tokens(&glsl);
    let is_used = |name: &str| all.iter().filter(|token| **token == name).count() > 1;
    let constants = glsl.split_inclusive(';').filter(|part| {
        let name = part.strip_prefix("const uint ").and_then(|rest| rest.split('=').next());
        name.is_none_or(is_used)
    });
    let glsl: String = constants.collect();
    let functions: BTreeSet<&str> = declarations(&glsl).filter_map(function_name).collect();
    let is_value = |token: &str| {
        let stem = token.trim_end_matches(|c: char| c.is_ascii_digit());
        let numbered = stem.len() < token.len()
            && (stem == "_e" || (stem.ends_with('_') && !stem.starts_with('_')));
        (numbered || token == "local") && !functions.contains(token)
    };
    let mut short = String::new();
    for declaration in declarations(&glsl) {
        let tokens = tokens(declaration);
        // In the order in which the function has them, which is the same everywhere.
        let (mut values, mut seen) = (Vec::new(), BTreeSet::new());
        for &token in tokens.iter().filter(|token| is_value(token)) {
            if seen.insert(token) {
                values.push(token);
            }
        }
        let renamed: BTreeMap<&str, String> = values.into_iter().zip(free_names(&tokens)).collect();
        short.extend(tokens.iter().map(|&token| renamed.get(token).map_or(token, String::as_str)));
    }
    short
}

/// The declarations of a shader, one after the other, with all between them.
pub fn declarations(glsl: &str) -> impl Iterator<Item = &str> {
    let mut depth = 0;
    glsl.split_inclusive(move |c: char| {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        depth == 0 && matches!(c, ';' | '}')
    })
}

/// The name of the function that is declared.
fn function_name(declaration: &str) -> Option<&str> {
    let (before, after) = declaration.split_once('(')?;
    let name = before.rsplit(|c: char| c.is_whitespace()).next()?;
    after.contains('{').then_some(name)
}

/// The shortest names that are free, for those that are used most.
fn short_names<'a>(
    counts: BTreeMap<&'a str, u32>,
    tokens: &[&'a str],
) -> BTreeMap<&'a str, String> {
    let mut often: Vec<(&str, u32)> = counts.into_iter().collect();
    often.sort_by_key(|&(name, count)| (std::cmp::Reverse(count), name));
    often.into_iter().map(|(name, _)| name).zip(free_names(tokens)).collect()
}

/// Names that none of the tokens has, the shortest first.
fn free_names(tokens: &[&str]) -> impl Iterator<Item = String> {
    let taken: BTreeSet<String> = tokens.iter().map(|token| token.to_string()).collect();
    let letters = || ('a'..='z').chain('A'..='Z');
    let pairs = letters().flat_map(move |a| letters().map(move |b| format!("{a}{b}")));
    let reserved = ["as", "do", "if", "in", "is", "of", "or", "fn"];
    letters()
        .map(String::from)
        .chain(pairs)
        .filter(move |name| !taken.contains(name) && !reserved.contains(&&name[..]))
}

/// Names, numbers, and the single characters between them.
pub fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let len = match first {
            c if c.is_numeric() => rest.find(|c: char| !is_word(c) && c != '.'),
            c if is_word(c) => rest.find(|c: char| !is_word(c)),
            c => Some(c.len_utf8()),
        };
        let (token, left) = rest.split_at(len.unwrap_or(rest.len()));
        tokens.push(token);
        rest = left;
    }
    tokens
}

/// Parses and validates a module. No capability is allowed that WebGL2 lacks.
pub fn validate(wgsl: &str) -> Result<(Module, ModuleInfo), String> {
    let module = naga::front::wgsl::parse_str(wgsl).map_err(|e| e.emit_to_string(wgsl))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|e| e.emit_to_string(wgsl))?;
    Ok((module, info))
}

/// Translates both stages of a draw: vertex, fragment.
pub fn translate(draw: &Draw, module: &Module) -> Result<[String; 2], String> {
    Ok([
        stage(module, ShaderStage::Vertex, draw.vertex)?,
        stage(module, ShaderStage::Fragment, draw.fragment)?,
    ])
}

fn stage(module: &Module, stage: ShaderStage, entry_point: &str) -> Result<String, String> {
    stage_with(module, stage, entry_point, &TEXTURES)
}

/// One stage, with no more of the module than it needs, and with these names for textures.
pub fn stage_with(
    module: &Module,
    shader_stage: ShaderStage,
    entry_point: &str,
    textures: &[&str],
) -> Result<String, String> {
    let mut module = module.clone();
    module.entry_points.retain(|entry| entry.name == entry_point);
    compact(&mut module, KeepUnused::No);
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|e| e.to_string())?;
    let options = glsl::Options {
        version: glsl::Version::Embedded { version: 300, is_webgl: true },
        // No flags: naga's flip of y and change of z would turn the picture over; the uniforms'
        // `y_axis` does it exactly.
        writer_flags: glsl::WriterFlags::empty(),
        ..Default::default()
    };
    let pipeline =
        glsl::PipelineOptions { shader_stage, entry_point: entry_point.into(), multiview: None };
    let mut text = String::new();
    let reflected = glsl::Writer::new(
        &mut text,
        &module,
        &info,
        &options,
        &pipeline,
        naga::proc::BoundsCheckPolicies::default(),
    )
    .and_then(|mut writer| writer.write())
    .map_err(|e| format!("{entry_point}: {e}"))?;
    // Naga's names are long, and others in each stage.
    for (long, mapping) in &reflected.texture_mapping {
        let binding = module.global_variables[mapping.texture].binding.map_or(0, |b| b.binding);
        let short = textures.get(binding as usize);
        text = text.replace(long, short.ok_or("a texture too many")?);
    }
    let is_block = |handle: Handle<GlobalVariable>| {
        module.global_variables[handle].space == AddressSpace::Uniform
    };
    let mut uniforms = reflected.uniforms.iter().filter(|&(&handle, _)| is_block(handle));
    if let Some((_, long)) = uniforms.next() {
        text = text.replace(long, UNIFORMS);
    }
    if uniforms.next().is_some() {
        return Err(format!("{entry_point}: more than one uniform block"));
    }
    for (long, short) in LONG_NAMES {
        text = text.replace(long, short);
    }
    Ok(text)
}

/// What naga calls the uniforms in either stage, what passes between the stages, and the colour.
const LONG_NAMES: [(&str, &str); 4] = [
    ("_group_0_binding_0_vs", "_u"),
    ("_group_0_binding_0_fs", "_u"),
    ("_vs2fs_location", "_v"),
    ("_fs2p_location", "_c"),
];

//! The shaders' passes: joined from their files, validated, and translated to the GLSL ES 3.00 that
//! WebGL2 takes. Shared by the build script and by `tests/suite/shaders.rs`.

use naga::back::glsl;
use naga::compact::{KeepUnused, compact};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, GlobalVariable, Handle, Module, ShaderStage};
use std::collections::{BTreeMap, BTreeSet};

/// A pass: its name, the files whose text makes it up, and its entry points.
pub struct Pass {
    pub name: &'static str,
    pub files: &'static [&'static str],
    pub vertex: &'static str,
    pub fragment: &'static str,
}

pub const PASSES: [Pass; 1] = [Pass {
    name: "picture",
    files: &["common.wgsl", "decode.wgsl", "styles.wgsl", "picture.wgsl"],
    vertex: "cover",
    fragment: "paint",
}];

/// A pass for WebGL2, with the names that naga gave to what has to be bound.
pub struct Glsl {
    pub vertex: String,
    pub fragment: String,
    /// The uniform block.
    pub uniforms: String,
    /// The textures' samplers, in the order of their bindings.
    pub textures: Vec<String>,
}

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

/// GLSL with a letter or two for each of the values that naga has numbered, and without the constants that it
/// has put in their places.
pub fn shorten_values(glsl: &str) -> String {
    let all = tokens(glsl);
    let is_used = |name: &str| all.iter().filter(|token| **token == name).count() > 1;
    let constants = glsl.split_inclusive(';').filter(|part| {
        let name = part.strip_prefix("const uint ").and_then(|rest| rest.split('=').next());
        name.is_none_or(is_used)
    });
    let glsl: String = constants.collect();
    let tokens = tokens(&glsl);
    let is_value = |token: &str| {
        token.strip_prefix("_e").is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()))
    };
    let mut counts = BTreeMap::new();
    for &token in tokens.iter().filter(|token| is_value(token)) {
        *counts.entry(token).or_insert(0) += 1;
    }
    // Values of different functions may share a name, as they shared a number.
    let short = short_names(counts, &tokens);
    tokens.iter().map(|&token| short.get(token).map_or(token, String::as_str)).collect()
}

/// The shortest names that are free, for those that are used most.
fn short_names<'a>(
    counts: BTreeMap<&'a str, u32>,
    tokens: &[&'a str],
) -> BTreeMap<&'a str, String> {
    let mut often: Vec<(&str, u32)> = counts.into_iter().collect();
    often.sort_by_key(|&(name, count)| (std::cmp::Reverse(count), name));
    let taken: BTreeSet<&str> = tokens.iter().copied().collect();
    let letters = || ('a'..='z').chain('A'..='Z');
    let pairs = letters().flat_map(|a| letters().map(move |b| format!("{a}{b}")));
    let reserved = ["as", "do", "if", "in", "is", "of", "or", "fn"];
    let free = letters().map(String::from).chain(pairs);
    let free = free.filter(|name| !taken.contains(&name[..]) && !reserved.contains(&&name[..]));
    often.into_iter().map(|(name, _)| name).zip(free).collect()
}

/// Names, numbers, and the single characters between them.
fn tokens(text: &str) -> Vec<&str> {
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

/// Parses and validates a pass. No capability is allowed that WebGL2 lacks.
pub fn validate(wgsl: &str) -> Result<(Module, ModuleInfo), String> {
    let module = naga::front::wgsl::parse_str(wgsl).map_err(|e| e.emit_to_string(wgsl))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|e| e.emit_to_string(wgsl))?;
    Ok((module, info))
}

/// Translates both stages of a pass.
pub fn translate(pass: &Pass, module: &Module) -> Result<Glsl, String> {
    let (vertex, ..) = stage(module, ShaderStage::Vertex, pass.vertex)?;
    let (fragment, names, module) = stage(module, ShaderStage::Fragment, pass.fragment)?;
    let binding = |handle: Handle<GlobalVariable>| {
        module.global_variables[handle].binding.map_or(0, |b| b.binding)
    };

    let mut textures: Vec<(u32, String)> = names
        .texture_mapping
        .iter()
        .map(|(name, mapping)| (binding(mapping.texture), name.clone()))
        .collect();
    textures.sort();
    let mut uniforms = names
        .uniforms
        .iter()
        .filter(|&(&handle, _)| module.global_variables[handle].space == AddressSpace::Uniform);
    match (uniforms.next(), uniforms.next()) {
        (Some((_, name)), None) => Ok(Glsl {
            vertex,
            fragment,
            uniforms: name.clone(),
            textures: textures.into_iter().map(|(_, name)| name).collect(),
        }),
        _ => Err(format!("{}: not exactly one uniform block", pass.name)),
    }
}

/// One stage, with no more of the module than it needs: the text, what naga called things, and that part.
fn stage(
    module: &Module,
    shader_stage: ShaderStage,
    entry_point: &str,
) -> Result<(String, glsl::ReflectionInfo, Module), String> {
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
    let names = glsl::Writer::new(
        &mut text,
        &module,
        &info,
        &options,
        &pipeline,
        naga::proc::BoundsCheckPolicies::default(),
    )
    .and_then(|mut writer| writer.write())
    .map_err(|e| format!("{entry_point}: {e}"))?;
    Ok((text, names, module))
}

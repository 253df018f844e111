//! The shaders' passes: joined from their files, validated, and translated to the GLSL ES 3.00 that
//! WebGL2 takes. Shared by the build script and by `tests/suite/shaders.rs`.

use naga::back::glsl;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, GlobalVariable, Handle, Module, ShaderStage};

/// A pass: its name, the files whose text makes it up, and its entry points.
pub struct Pass {
    pub name: &'static str,
    pub files: &'static [&'static str],
    pub vertex: &'static str,
    pub fragment: &'static str,
}

pub const PASSES: [Pass; 1] = [Pass {
    name: "picture",
    files: &["common.wgsl", "decode.wgsl", "picture.wgsl"],
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

/// WGSL or GLSL without comments and indentation: it travels inside the WebAssembly module.
pub fn minify(source: &str) -> String {
    let mut short = String::new();
    for line in source.lines() {
        let code = line.split("//").next().unwrap_or_default().trim();
        if !code.is_empty() {
            short.push_str(code);
            short.push('\n');
        }
    }
    short
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
pub fn translate(pass: &Pass, module: &Module, info: &ModuleInfo) -> Result<Glsl, String> {
    let (vertex, _) = stage(module, info, ShaderStage::Vertex, pass.vertex)?;
    let (fragment, names) = stage(module, info, ShaderStage::Fragment, pass.fragment)?;
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

fn stage(
    module: &Module,
    info: &ModuleInfo,
    shader_stage: ShaderStage,
    entry_point: &str,
) -> Result<(String, glsl::ReflectionInfo), String> {
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
        module,
        info,
        &options,
        &pipeline,
        naga::proc::BoundsCheckPolicies::default(),
    )
    .and_then(|mut writer| writer.write())
    .map_err(|e| format!("{entry_point}: {e}"))?;
    Ok((text, names))
}

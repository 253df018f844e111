//! The shaders: joined from their files, validated, and translated to the GLSL ES 3.00 that
//! WebGL2 takes. Shared by the build script and by `tests/suite/shaders.rs`.

use naga::back::glsl;
use naga::compact::{KeepUnused, compact};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, GlobalVariable, Handle, Module, ShaderStage};

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
    files: &[
        "common.wgsl",
        "decode.wgsl",
        "styles.wgsl",
        "seen.wgsl",
        "survey.wgsl",
        "picture.wgsl",
        "far.wgsl",
    ],
    draws: &[
        Draw { vertex: "place_corner", fragment: "paint_one" },
        Draw { vertex: "place_corner", fragment: "paint_two" },
        Draw { vertex: "place_corner", fragment: "paint_rest" },
        Draw { vertex: "place_corner", fragment: "paint_sampled" },
        Draw { vertex: "place_corner", fragment: "paint_styled" },
        Draw { vertex: "cover", fragment: "paint_far" },
        Draw { vertex: "cover", fragment: "survey_patch" },
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
pub const TEXTURES: [&str; 5] = ["_0", "_1", "_2", "_3", "_4"];

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
    Ok(with_breaks_last(text))
}

/// The same with loops that end with a break, and go on before that where they do, in place of those that break where they do
/// not. It means the same; but Mesa's llvmpipe below WebGL2 gives of the others what a further turn makes of it to
/// pixels that have had enough, where pixels beside them take one.
pub fn with_breaks_last(mut text: String) -> String {
    const LOOP: &str = "while(true) {";
    let starts: Vec<usize> = text.match_indices(LOOP).map(|(at, _)| at + LOOP.len()).collect();
    // From the last on, so that what is before stays where it is.
    for start in starts.into_iter().rev() {
        let mut depth = 1;
        let close = text[start..].find(|c| {
            depth += i32::from(c == '{') - i32::from(c == '}');
            depth == 0
        });
        let Some(body) = close.map(|close| &text[start..start + close]) else { continue };
        let Some((before, rest)) = body.rsplit_once("break;") else { continue };
        let (before, rest) =
            (before.trim_end().strip_suffix('{'), rest.trim_start().strip_prefix('}'));
        let (Some(before), Some(rest)) = (before, rest) else { continue };
        if rest.trim_start().starts_with("else") {
            continue;
        }
        let is_within = before.matches('{').count() != before.matches('}').count();
        let condition = before.trim_end().strip_suffix(')');
        let Some(condition) = condition.filter(|_| !is_within) else { continue };
        let mut depth = 1;
        let open = condition.rfind(|c| {
            depth += i32::from(c == ')') - i32::from(c == '(');
            depth == 0
        });
        let Some(open) = open.filter(|&open| condition[..open].trim_end().ends_with("if")) else {
            continue;
        };
        let (head, condition) = (&condition[..open], &condition[open + 1..]);
        let last = format!("{head}(!({condition})) {{{rest}\ncontinue;\n}}\nbreak;\n");
        text.replace_range(start..start + body.len(), &last);
    }
    text
}

/// What naga calls the uniforms in either stage, what passes between the stages, and the colour.
const LONG_NAMES: [(&str, &str); 4] = [
    ("_group_0_binding_0_vs", "_u"),
    ("_group_0_binding_0_fs", "_u"),
    ("_vs2fs_location", "_v"),
    ("_fs2p_location", "_c"),
];

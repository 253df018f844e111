//! Shaders without a GPU: they are valid, they translate for WebGL2, and their constants and
//! uniforms are those of their Rust twins.

#[path = "../../shaders/needless.rs"]
mod needless;
#[path = "../../shaders/paste.rs"]
mod paste;
#[path = "../../shaders/shorten.rs"]
mod shorten;
#[path = "../../shaders/translate.rs"]
mod translate;

use shorten::{minify, shorten, shorten_values};
use translate::{
    Draw, MODULES, Shaders, TEXTURES, UNIFORMS, translate, validate, with_breaks_last,
};

fn wgsl(shaders: &Shaders) -> String {
    joined(shaders.files)
}

fn joined(files: &[&str]) -> String {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    files.iter().map(|file| std::fs::read_to_string(folder.join(file)).unwrap()).collect()
}

/// The material's texts.
pub fn pasted() -> paste::Material {
    paste::material(&joined(&paste::FILES)).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn every_draw_is_valid_and_translates_to_webgl2() {
    for shaders in &MODULES {
        let minified = minify(&wgsl(shaders));
        let short = shorten(&minified, &shaders.entry_points());
        assert!(short.len() * 4 < minified.len() * 3, "{} of {}", short.len(), minified.len());
        for text in [wgsl(shaders), minified, short] {
            let (module, _) = validate(&text).unwrap_or_else(|e| panic!("{}: {e}", shaders.name));
            for draw in shaders.draws {
                let stages = translate(draw, &module).unwrap();
                for stage in &stages {
                    let short = shorten_values(&minify(stage));
                    assert!(short.len() * 10 < stage.len() * 9, "{}", draw.fragment);
                    assert!(stage.starts_with("#version 300 es"), "{}: {stage}", draw.fragment);
                }
                let textures: &[usize] = match draw.fragment {
                    "paint_far" => &[0],
                    "survey_patch" => &[0, 1, 2, 3],
                    "paint_one" | "paint_two" => &[0, 1, 2, 4],
                    _ => &[0, 1, 2, 3, 4],
                };
                let textures = textures.iter().map(|&i| &TEXTURES[i]);
                for name in textures.chain([&UNIFORMS]) {
                    let declared = format!(" {name}{}", if *name == UNIFORMS { "{" } else { ";" });
                    let is_there = |stage: &String| minify(stage).contains(&declared);
                    assert!(stages.iter().any(is_there), "{}: {name}", draw.fragment);
                }
            }
        }
    }
}

#[test]
fn the_material_is_functions_that_a_program_can_paste() {
    let paste::Material { wgsl, glsl } = pasted();
    let (module, _) = validate(&wgsl).unwrap();
    assert!(module.entry_points.is_empty());
    // What it has at all is its own by name, and so no program's.
    let globals = module.global_variables.iter().filter_map(|(_, global)| global.name.as_ref());
    let functions = module.functions.iter().filter_map(|(_, function)| function.name.as_ref());
    let types = module.types.iter().filter_map(|(_, ty)| ty.name.as_ref());
    for name in globals.chain(functions).chain(types) {
        assert!(name.starts_with("istar_"), "{name}");
    }
    for function in ["istar_sample", "istar_sample_from", "istar_region"] {
        assert!(wgsl.contains(&format!("fn {function}(")), "{function}");
        assert!(glsl.contains(&format!(" {function}(")), "{function}: {glsl}");
    }
    for (binding, name) in paste::TEXTURES.iter().enumerate() {
        assert!(wgsl.contains(&format!("@group(1) @binding({binding}) var {name}:")), "{name}");
        assert!(glsl.contains(&format!(" {name};")), "{name}");
    }
    for word in ["#version", "main(", "layout(location", "gl_FragCoord", "_group_"] {
        assert!(!glsl.contains(word), "{word}: {glsl}");
    }
}

#[test]
fn what_changes_nothing_is_left_out_of_glsl() {
    for (with, without) in [
        ("x=((a*b)+c);", "x=a*b+c;"),
        ("x=(a*(b+c));", "x=a*(b+c);"),
        ("x=((a-b)-c);", "x=a-b-c;"),
        ("x=(a-(b-c));", "x=a-(b-c);"),
        ("x=(a/(b*c));", "x=a/(b*c);"),
        ("x=(a-(-(b)));", "x=a- -b;"),
        ("x=-((a*b));", "x=-(a*b);"),
        ("x=-(-(a));", "x=-(-a);"),
        ("x=(!((a==b))&&!(c));", "x=!(a==b)&&!c;"),
        ("x=((a<b)?(c+d):((e?f:g)));", "x=a<b?c+d:(e?f:g);"),
        ("x=((a?b:c)?d:e);", "x=(a?b:c)?d:e;"),
        ("x=((a&b)!=0u);", "x=(a&b)!=0u;"),
        ("x=((a>>2u)&(b|c));", "x=a>>2u&(b|c);"),
        ("x=vec2((a+1e-30),((b)));", "x=vec2(a+1e-30,b);"),
        ("x=((a+b).x*c[(i+1u)]);", "x=(a+b).x*c[i+1u];"),
        ("if(((a)&&(b<c))){return(d);}return(-(e));", "if(a&&b<c)return d;return-e;"),
        ("if(a){b;}else{if(c){d;e;}}", "if(a)b;else{if(c){d;e;}}"),
        ("if(a){if(b)c;}else{d;}", "if(a){if(b)c;}else d;"),
        ("void f(){while(true){if((a)){break;}}}", "void f(){while(true){if(a)break;}}"),
        ("float f(vec2 a){return(0.5*a.x+1.0);}", "float f(vec2 a){return .5*a.x+1.;}"),
        ("x=0.0+10.0-1.05+a0.x+2u;", "x=0.+10.-1.05+a0.x+2u;"),
        ("#version 300 es\n\nprecision highp float;", "#version 300 es\n\nprecision highp float;"),
    ] {
        assert_eq!(needless::without_needless(with), without);
        assert_eq!(needless::without_needless(without), without);
    }
}

#[test]
fn loops_end_with_a_break() {
    for (with, without) in [
        (
            "while(true) {a; if ((b < c(d))) {break; }\n}e;",
            "while(true) {a; if (!((b < c(d)))) {continue;}break;}e;",
        ),
        (
            "while(true) {while(true) {if (a) {break;}}if (b) {break;}}",
            "while(true) {while(true) {if (!(a)) {continue;}break;}if (!(b)) {continue;}break;}",
        ),
        ("while(true) {if (a) {break;}b;}e;", "while(true) {if (!(a)) {b;continue;}break;}e;"),
        // Those that do something else, or end with something else.
        ("while(true) {if (a) {if (b) {break;}}}", "while(true) {if (a) {if (b) {break;}}}"),
        ("while(true) {if (a) {b;break;}}", "while(true) {if (a) {b;break;}}"),
        ("if (a) {while(true) {b;}}", "if (a) {while(true) {b;}}"),
        ("while(true) {if (a) {b;} else {break;}}", "while(true) {if (a) {b;} else {break;}}"),
    ] {
        assert_eq!(with_breaks_last(with.into()).replace('\n', ""), without);
    }
    for draw in MODULES[0].draws {
        let (module, _) = validate(&wgsl(&MODULES[0])).unwrap();
        for stage in translate(draw, &module).unwrap() {
            let loops = stage.matches("while(true)").count();
            assert_eq!(
                minify(&stage).matches("continue;}break;}").count(),
                loops,
                "{}",
                draw.fragment
            );
        }
    }
}

#[test]
fn names_of_a_function_are_in_the_order_in_which_it_has_them() {
    let wgsl = "const far=2.0;fn at(place:vec2<f32>,by:f32)->f32{let at=at(place.yx,far);var sum=at;\
                loop{let by=sum;sum+=by*place.x;}return sum+by;}";
    assert_eq!(
        shorten(wgsl, &[]),
        "const e=2.0;fn a(b:vec2<f32>,c:f32)->f32{let d=a(b.yx,e);var f=d;\
         loop{let c=f;f+=c*b.x;}return f+c;}"
    );
}

#[test]
fn glsl_declares_what_it_has_where_it_is_set() {
    for (long, short) in [
        // Numbers in the places of constants, and names in order.
        (
            "const uint be=4u;uint f(uint q,S be_1){return q&be+be_1.be;}",
            "uint f(uint a,S b){return a&4u+b.be;}",
        ),
        (
            "layout(std140)uniform _b{S _u;};struct S{vec2 s;};flat in vec3 _v1;",
            "layout(std140)uniform _b{S _u;};struct S{vec2 s;};flat in vec3 _v1;",
        ),
        // Set later, and in a block that has all of it.
        (
            "float f(float q){float s=0.;float t_1=q*q;g(t_1,t_1);s=t_1;h(s,s);return s;}",
            "float f(float a){float b=a*a;g(b,b);float c=b;h(c,c);return c;}",
        ),
        ("void f(){float s=0.;if(c){s=1.;h(s,s);}}", "void f(){if(c){float a=1.;h(a,a);}}"),
        // Not where some have use for what it was before: after the block, in what sets it, or where it is set in part.
        (
            "float f(){float s=0.;if(c){s=1.;}return s;}",
            "float f(){float a=0.;if(c){a=1.;}return a;}",
        ),
        (
            "float f(){float s=0.;h(1.);s=s+1.;return s+s;}",
            "float f(){float a=0.;h(1.);a=a+1.;return a+a;}",
        ),
        (
            "vec2 f(){vec2 s=vec2(0.);h(1.);s.x=1.;return s+s;}",
            "vec2 f(){vec2 a=vec2(0.);h(1.);a.x=1.;return a+a;}",
        ),
        (
            "void f(){float s=0.;while(true){if(s>1.){break;}s=2.;}}",
            "void f(){float a=0.;while(true){if(a>1.){break;}a=2.;}}",
        ),
    ] {
        assert_eq!(shorten_values(long), short);
    }
}

#[test]
fn every_shader_file_belongs_to_a_module() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    for entry in std::fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let used = MODULES.iter().any(|shaders| shaders.files.contains(&name.as_str()))
            || paste::FILES.contains(&name.as_str());
        assert!(used || !name.ends_with(".wgsl"), "{name} is in no module and would go untested");
    }
}

#[test]
fn a_capability_that_webgl2_lacks_is_refused() {
    let fragment = "@group(0) @binding(0) var<storage> words: array<u32>;\n\
                   @fragment fn paint() -> @location(0) vec4<f32> { return vec4(f32(words[0])); }";
    let storage = format!(
        "{fragment}\n@vertex fn cover() -> @builtin(position) vec4<f32> {{ return vec4(0.0); }}"
    );
    let draw = Draw { vertex: "cover", fragment: "paint" };
    let translated = validate(&storage).map(|(module, _)| translate(&draw, &module));
    assert!(!matches!(translated, Ok(Ok(_))), "storage buffers would pass unnoticed");
}

/// The Rust twins are there only with the feature.
#[cfg(feature = "gpu")]
mod twins {
    use super::{MODULES, validate, wgsl};
    use istar::MAX_CANDIDATES;
    use istar::gpu::{MAX_SAMPLES, ViewUniforms, WIDTH};
    use naga::{Expression, Literal, Module, TypeInner};

    /// A view in which no two numbers are alike.
    const VIEW: ViewUniforms = ViewUniforms {
        edges: [1.5, 2.5, 3.5, 4.5],
        middles: [41.0, 42.0, 43.0, 44.0],
        turn: [45.0, 46.0, 47.0, 48.0],
        clip: [49.0, 50.0, 51.0, 52.0],
        anchor: [5, 6],
        offset: [0.7, 0.8],
        last: [9, 10],
        middle: [11.0, 12.0],
        shift: [-13.0, 14.0],
        to_clip: [27.0, 28.0],
        patches: [29, 30],
        start: [31.0, 32.0],
        split: [20.0, 21.0],
        pixel: 15.0,
        sub_pixel: 16.0,
        samples: 17,
        block_log2: 18,
        patch_width: 33.0,
        flags: 19,
        reach: 22.0,
        texel: 34.0,
        survey: [35, 36],
        pattern: [23.0, 24.0, 25.0, 26.0],
    };

    #[test]
    fn the_uniforms_lie_where_the_shader_reads_them() {
        let view = VIEW;
        let float = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let int = |values: &[i32]| values.iter().map(|&v| v as u32).collect::<Vec<_>>();
        let twin = [
            ("edges", float(&view.edges)),
            ("middles", float(&view.middles)),
            ("turn", float(&view.turn)),
            ("clip", float(&view.clip)),
            ("anchor", int(&view.anchor)),
            ("offset", float(&view.offset)),
            ("last", int(&view.last)),
            ("middle", float(&view.middle)),
            ("shift", float(&view.shift)),
            ("to_clip", float(&view.to_clip)),
            ("patches", view.patches.to_vec()),
            ("start", float(&view.start)),
            ("split", float(&view.split)),
            ("pixel", float(&[view.pixel])),
            ("sub_pixel", float(&[view.sub_pixel])),
            ("samples", vec![view.samples]),
            ("block_log2", vec![view.block_log2]),
            ("patch_width", float(&[view.patch_width])),
            ("flags", vec![view.flags]),
            ("reach", float(&[view.reach])),
            ("texel", float(&[view.texel])),
            ("survey", view.survey.to_vec()),
            ("pattern", float(&view.pattern)),
        ];
        let bytes = view.as_bytes();
        for shaders in &MODULES {
            let (module, _) = validate(&wgsl(shaders)).unwrap();
            let (_, ty) =
                module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some("View")).unwrap();
            let TypeInner::Struct { members, span } = &ty.inner else {
                panic!("View is no struct")
            };
            assert_eq!(*span as usize, ViewUniforms::SIZE);
            assert_eq!(members.len(), twin.len());
            for (member, (name, words)) in members.iter().zip(&twin) {
                assert_eq!(member.name.as_deref(), Some(*name));
                let size = module.types[member.ty].inner.size(module.to_ctx()) as usize;
                assert_eq!(size, words.len() * 4, "{name}");
                let at = member.offset as usize;
                let there = bytes[at..at + size].as_chunks::<4>().0;
                let there: Vec<u32> = there.iter().map(|&word| u32::from_le_bytes(word)).collect();
                assert_eq!(&there, words, "{name}");
            }
        }
    }

    #[test]
    fn the_constants_are_the_twins() {
        let twin = [
            ("ANTIALIAS", ViewUniforms::ANTIALIAS),
            ("STRAIGHT", ViewUniforms::STRAIGHT),
            ("CLOSE", ViewUniforms::CLOSE),
            ("OUTLINES", ViewUniforms::OUTLINES),
            ("PATCHES", ViewUniforms::PATCHES),
            ("TURNED", ViewUniforms::TURNED),
            ("CUT_AT_BORDERS", ViewUniforms::CUT_AT_BORDERS),
            ("CORNERS", ViewUniforms::CORNERS),
            ("MAX_CANDIDATES", MAX_CANDIDATES as u32),
            ("MAX_SAMPLES", MAX_SAMPLES),
            ("WIDTH_LOG2", WIDTH.trailing_zeros()),
        ];
        let (module, _) = validate(&wgsl(&MODULES[0])).unwrap();
        for (name, value) in twin {
            assert_eq!(constant(&module, name), Some(value), "{name}");
        }
    }

    fn constant(module: &Module, name: &str) -> Option<u32> {
        let mut constants = module.constants.iter();
        let (_, constant) = constants.find(|(_, c)| c.name.as_deref() == Some(name))?;
        match module.global_expressions[constant.init] {
            Expression::Literal(Literal::U32(value)) => Some(value),
            _ => None,
        }
    }
}

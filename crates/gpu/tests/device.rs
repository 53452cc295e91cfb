//! The device against hand-known answers.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_gpu::testing::{choice, test_gpu};
use dapple_gpu::{AdapterChoice, Gpu, GpuError, MAX_PASSES, Targets, adapters, copy_rate, wgpu};

const DOUBLE: &str = "
@group(0) @binding(0) var<storage, read_write> values: array<u32>;
override factor: u32 = 2u;
@compute @workgroup_size(64)
fn scale(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&values) { values[id.x] *= factor; }
}
@compute @workgroup_size(64)
fn every_second(@builtin(global_invocation_id) id: vec3<u32>) {
    if 2u * id.x < arrayLength(&values) { values[2u * id.x] = id.x; }
}";

/// What a new buffer holds.
const POISON: u32 = 0xA5A5_A5A5;

fn pipeline(gpu: &Gpu, entry: &str, constants: &[(&str, f64)]) -> wgpu::ComputePipeline {
    let module = gpu.module_of("test", DOUBLE).unwrap();
    gpu.compute_of(&module, "test", entry, constants).unwrap()
}

fn dispatch(gpu: &Gpu, pipeline: &wgpu::ComputePipeline, buffer: &wgpu::Buffer) {
    let group = gpu.bind(pipeline, 0, &[buffer]);
    let mut frame = gpu.frame();
    frame.compute("test", |pass| {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(1, 1, 1);
    });
    frame.finish().unwrap();
}

#[test]
fn a_kernel_doubles_numbers() {
    let Some(gpu) = test_gpu() else { return };
    let values = gpu.upload("values", &[1u32, 2, 3, 4, 50]).unwrap();
    dispatch(gpu, &pipeline(gpu, "scale", &[]), &values);
    assert_eq!(gpu.read::<u32>(&values, 0, 5).unwrap(), [2, 4, 6, 8, 100]);
    dispatch(gpu, &pipeline(gpu, "scale", &[("factor", 10.0)]), &values);
    assert_eq!(gpu.read::<u32>(&values, 4, 2).unwrap(), [40, 60]);
}

#[test]
fn a_kernel_sees_exactly_the_length_of_its_buffer() {
    let Some(gpu) = test_gpu() else { return };
    let module = gpu
        .module_of(
            "length",
            "@group(0) @binding(0) var<storage, read_write> values: array<u32>;
            @compute @workgroup_size(1) fn length() { values[0] = arrayLength(&values); }",
        )
        .unwrap();
    let pipeline = gpu.compute_of(&module, "length", "length", &[]).unwrap();
    for words in [4, 5, 18, 1000] {
        let values = gpu.upload("values", &vec![0u32; words]).unwrap();
        dispatch(gpu, &pipeline, &values);
        assert_eq!(gpu.read::<u32>(&values, 0, 1).unwrap(), [words as u32]);
    }
}

#[test]
fn poison_shows_every_word_that_was_not_written() {
    let Some(gpu) = test_gpu() else { return };
    let values = gpu.buffer("values", 32).unwrap();
    assert_eq!(gpu.read::<u32>(&values, 0, 8).unwrap(), [POISON; 8]);
    dispatch(gpu, &pipeline(gpu, "every_second", &[]), &values);
    let expected = [0, POISON, 1, POISON, 2, POISON, 3, POISON];
    assert_eq!(gpu.read::<u32>(&values, 0, 8).unwrap(), expected);
    gpu.poison(&values);
    assert_eq!(gpu.read::<u32>(&values, 0, 8).unwrap(), [POISON; 8]);
    // Larger than the buffer that poison is copied from, and no multiple of it.
    let large = gpu.buffer("large", 3 * (1 << 20) + 20).unwrap();
    let words = gpu.read::<u32>(&large, 0, large.size() as usize / 4).unwrap();
    assert!(words.len() == 3 * (1 << 18) + 5 && words.iter().all(|w| *w == POISON));
}

#[test]
fn read_back_takes_any_offset_and_refuses_what_is_beyond_the_end() {
    let Some(gpu) = test_gpu() else { return };
    let bytes: Vec<u8> = (0..20).collect();
    let buffer = gpu.upload("bytes", &bytes).unwrap();
    for (offset, count) in [(0, 20), (1, 3), (3, 17), (19, 1), (20, 0)] {
        let read = gpu.read::<u8>(&buffer, offset, count).unwrap();
        assert_eq!(read, bytes[offset as usize..][..count], "{offset} {count}");
    }
    for (offset, count) in [(0, 21), (20, 1), (u64::MAX, 1), (0, usize::MAX)] {
        let error = gpu.read::<u8>(&buffer, offset, count).unwrap_err();
        assert!(matches!(error, GpuError::TooLarge { max: 20, .. }), "{error}");
    }
}

#[test]
fn small_and_empty_uploads_are_padded_to_sixteen_bytes() {
    let Some(gpu) = test_gpu() else { return };
    assert_eq!(gpu.upload::<f32>("empty", &[]).unwrap().size(), 16);
    let one = gpu.upload("one", &[7u8]).unwrap();
    let expected: Vec<u8> = std::iter::once(7).chain([0xA5; 15]).collect();
    assert_eq!(gpu.read::<u8>(&one, 0, 16).unwrap(), expected);
    assert_eq!(gpu.uniform("value", &[1.0f32; 5]).unwrap().size(), 20);
}

#[test]
fn a_size_over_the_limit_is_refused_by_name_before_it_is_tried() {
    let Some(gpu) = test_gpu() else { return };
    let limits = gpu.limits();
    let most = limits.max_storage_buffer_binding_size;
    for bytes in [most + 1, limits.max_buffer_size.max(most) + 1, u64::MAX] {
        let error = gpu.buffer("too large", bytes).unwrap_err();
        assert!(matches!(error, GpuError::TooLarge { .. }), "{error}");
        let text = error.to_string();
        assert!(text.contains("`too large`") && text.contains("max_"), "{text}");
    }
    let side = limits.max_texture_dimension_2d + 1;
    let (format, usage) = (wgpu::TextureFormat::R32Float, wgpu::TextureUsages::COPY_SRC);
    let error = gpu.texture("map", side, 1, format, usage).unwrap_err();
    assert!(error.to_string().contains("max_texture_dimension_2d"), "{error}");
    let error = gpu.texture("map", 0, 1, format, usage).unwrap_err();
    assert!(matches!(&error, GpuError::Validation { what, .. } if what.contains("map")), "{error}");
}

#[test]
fn validation_errors_are_typed_and_the_device_lives_on() {
    if test_gpu().is_none() {
        return;
    }
    // A device of its own: what is left in `check` must not reach other tests.
    let gpu = Gpu::open(&choice()).unwrap();
    let is = |error: GpuError, part: &str| match error {
        GpuError::Validation { what, message } => {
            assert!(what.contains(part), "`{part}` not in `{what}`: {message}");
        }
        other => panic!("{other}"),
    };
    is(gpu.module_of("broken", "fn f( {").unwrap_err(), "broken");
    is(gpu.compute("gpu/copy.wgsl", "no_such_entry", &[]).unwrap_err(), "gpu/copy.wgsl");
    is(gpu.compute("gpu/copy.wgsl", "copy", &[("no_such", 1.0)]).unwrap_err(), "gpu/copy.wgsl");
    let unknown = gpu.compute("no/such.wgsl", "main", &[]).unwrap_err();
    assert!(matches!(unknown, GpuError::Shader(_)), "{unknown}");

    // One buffer too many: reported by the next check, once.
    let copy = gpu.compute("gpu/copy.wgsl", "copy", &[]).unwrap();
    let buffer = gpu.upload("one", &[1u32; 4]).unwrap();
    gpu.check().unwrap();
    let _ = gpu.bind(&copy, 0, &[&buffer, &buffer, &buffer]);
    is(gpu.check().unwrap_err(), "");
    gpu.check().unwrap();

    // A pass without its bind group: reported by the frame.
    let mut frame = gpu.frame();
    frame.compute("unbound", |pass| {
        pass.set_pipeline(&copy);
        pass.dispatch_workgroups(1, 1, 1);
    });
    is(frame.finish().unwrap_err(), "frame");

    let values = gpu.upload("values", &[21u32; 4]).unwrap();
    dispatch(&gpu, &pipeline(&gpu, "scale", &[]), &values);
    assert_eq!(gpu.read::<u32>(&values, 0, 4).unwrap(), [42; 4]);
}

#[test]
fn a_lost_device_is_an_error_of_every_later_call() {
    if test_gpu().is_none() {
        return;
    }
    let gpu = Gpu::open(&choice()).unwrap();
    let values = gpu.upload("values", &[1u32; 4]).unwrap();
    gpu.device.destroy();
    let lost = |error: GpuError| assert!(matches!(error, GpuError::DeviceLost(_)), "{error}");
    lost(gpu.check().unwrap_err());
    lost(gpu.check().unwrap_err());
    lost(gpu.frame().finish().unwrap_err());
    lost(gpu.read::<u32>(&values, 0, 4).unwrap_err());
    lost(gpu.upload("more", &[1u32]).unwrap_err());
    lost(gpu.compute("gpu/copy.wgsl", "copy", &[]).unwrap_err());
}

#[test]
fn a_frame_reports_its_passes_by_name_in_order() {
    let Some(gpu) = test_gpu() else { return };
    let values = gpu.upload("values", &vec![1u32; 1 << 16]).unwrap();
    let pipeline = pipeline(gpu, "scale", &[]);
    let group = gpu.bind(&pipeline, 0, &[&values]);
    let mut frame = gpu.frame();
    for name in ["first", "second"] {
        frame.compute(name, |pass| {
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(1 << 10, 1, 1);
        });
    }
    frame.copies("third", |encoder| encoder.clear_buffer(&values, 0, None));
    let times = frame.finish().unwrap();
    assert!(times.wall_ns > 0);
    assert_eq!(times.fault, None);
    if !gpu.abilities.timestamps {
        dapple_gpu::testing::say_not_run(&format!("no sound timestamps on {}", gpu.facts.line()));
        assert_eq!((times.gpu_ns, times.passes), (None, Vec::new()));
        return;
    }
    let names: Vec<_> = times.passes.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["first", "second", "third"]);
    let sum = times.passes.iter().map(|(_, ns)| ns).sum();
    assert_eq!(times.gpu_ns, Some(sum));
    assert!(sum > 0 && sum as f64 <= 1.05 * times.wall_ns as f64, "{times:?}");
}

#[test]
fn more_work_takes_more_device_time() {
    let Some(gpu) = test_gpu().filter(|gpu| gpu.abilities.timestamps) else { return };
    let result = gpu.buffer("result", 4 * 16_384).unwrap();
    let pipeline = gpu.compute("gpu/work.wgsl", "work", &[]).unwrap();
    let time = |length: u32| {
        let iterations = gpu.upload("iterations", &[length]).unwrap();
        let group = gpu.bind(&pipeline, 0, &[&iterations, &result]);
        let one = || {
            let mut frame = gpu.frame();
            frame.compute("work", |pass| {
                pass.set_pipeline(&pipeline);
                pass.set_bind_group(0, &group, &[]);
                pass.dispatch_workgroups(256, 1, 1);
            });
            frame.finish().unwrap().gpu_ns.unwrap()
        };
        one();
        (0..5).map(|_| one()).min().unwrap()
    };
    // 64 times the work, far above what other load on the machine does to the least of five.
    let (short, long) = (time(500), time(32_000));
    assert!(long > 8 * short, "{short} ns, then {long} ns for 64 times the work");
}

#[test]
fn a_frame_of_too_many_passes_is_refused_and_an_empty_one_is_not() {
    let Some(gpu) = test_gpu() else { return };
    let mut frame = gpu.frame();
    for _ in 0..=MAX_PASSES {
        frame.compute("pass", |_| {});
    }
    let error = frame.finish().unwrap_err();
    assert!(error.to_string().contains("MAX_PASSES"), "{error}");
    let times = gpu.frame().finish().unwrap();
    assert_eq!(times.passes, []);
}

/// Draws `entry` of the triangle shader over an R32Float image of zeros; the image.
fn draw(gpu: &Gpu, entry: &str, width: u32, height: u32) -> Vec<f32> {
    let format = wgpu::TextureFormat::R32Float;
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
    let image = gpu.texture("image", width, height, format, usage).unwrap();
    let view = image.create_view(&Default::default());
    let module = gpu.module("gpu/triangle.wgsl").unwrap();
    let pipeline = gpu
        .raster(
            "triangle",
            &wgpu::RenderPipelineDescriptor {
                label: None,
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(entry),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: None,
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("red"),
                    compilation_options: Default::default(),
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            },
        )
        .unwrap();
    let mut frame = gpu.frame();
    let colour = [Targets::cleared(&view, wgpu::Color::BLACK)];
    frame.raster("triangle", Targets { colour: &colour, ..Default::default() }, |pass| {
        pass.set_pipeline(&pipeline);
        pass.draw(0..3, 0..1);
    });
    frame.finish().unwrap();
    gpu.read_f32(&image).unwrap()
}

#[test]
fn a_triangle_covers_the_pixels_whose_centres_it_holds() {
    let Some(gpu) = test_gpu() else { return };
    // Lower left half of 64 x 64. 64 centres lie on the hypotenuse, which as a right edge owns
    // none of them: 64 * 63 / 2 are left. Column x of row y (from the top) is inside if x < y.
    let image = draw(gpu, "lower_left", 64, 64);
    assert_eq!(image.iter().filter(|v| **v == 1.0).count(), 2016);
    for (i, value) in image.iter().enumerate() {
        let (x, y) = (i % 64, i / 64);
        assert_eq!(*value, if x < y { 1.0 } else { 0.0 }, "({x}, {y})");
    }
}

#[test]
fn texture_read_back_drops_the_padding_of_rows() {
    let Some(gpu) = test_gpu() else { return };
    // 5 texels are 20 bytes of a row of 256.
    let image = draw(gpu, "full", 5, 3);
    assert_eq!(image, [1.0; 15]);
    // Inside: (x + 0.5) / 5 < (y + 0.5) / 3.
    let image = draw(gpu, "lower_left", 5, 3);
    let expected = [1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 1, 1, 1, 1, 0].map(|v| v as f32);
    assert_eq!(image, expected);
}

#[test]
fn copy_rate_is_positive_and_finite_at_any_footprint() {
    let Some(gpu) = test_gpu() else { return };
    for bytes in [0, 100, 32 << 20] {
        let rate = copy_rate(gpu, bytes).unwrap();
        assert!(rate.is_finite() && rate > 1e6, "{bytes} bytes at {rate} bytes/s");
        eprintln!("{bytes} bytes: {:.2} GB/s on {}", rate / 1e9, gpu.facts.line());
    }
    let error = copy_rate(gpu, u64::MAX).unwrap_err();
    assert!(matches!(error, GpuError::TooLarge { limit: "max_buffer_size", .. }), "{error}");
}

#[test]
fn every_adapter_is_listed_and_an_unknown_name_lists_them() {
    let Some(gpu) = test_gpu() else { return };
    let all = adapters();
    assert!(all.contains(&gpu.facts), "{all:?}");
    assert!(all.is_sorted_by_key(|facts| facts.kind), "{all:?}");
    let error = Gpu::open(&AdapterChoice::Named("no such adapter".into())).unwrap_err();
    assert!(error.to_string().contains(&gpu.facts.name), "{error}");
}

#[test]
fn probes_of_this_adapter_are_consistent() {
    let Some(gpu) = test_gpu() else { return };
    eprintln!("{}: {:#?}", gpu.facts.line(), gpu.abilities);
    assert!(gpu.abilities.loops_sound);
    assert!(gpu.abilities.max_workgroup >= 256);
    assert!(!gpu.abilities.occlusion_exact_counts || gpu.abilities.occlusion_boolean);
    if gpu.facts.name.contains("llvmpipe") {
        // Known of Mesa's software rasteriser: exact counts, RNE packs, truncating stores.
        let a = &gpu.abilities;
        assert!(a.occlusion_exact_counts && a.f16_pack_rne && !a.f16_store_rne && a.timestamps);
        assert!(a.f32_division_rne && a.notes.is_empty());
    }
}

#[test]
fn threads_that_share_a_device_each_read_their_own() {
    let Some(gpu) = test_gpu() else { return };
    std::thread::scope(|scope| {
        for thread in 0..4_u32 {
            scope.spawn(move || {
                for turn in 0..50 {
                    let words = [thread, turn, thread ^ turn, 7];
                    let buffer = gpu.upload("shared", &words).unwrap();
                    assert_eq!(gpu.read::<u32>(&buffer, 0, 4).unwrap(), words);
                }
            });
        }
    });
}

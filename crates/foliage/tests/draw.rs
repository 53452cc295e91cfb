//! The draws that the extractors leave behind, issued: the leaves seen are the leaves kept.

#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use dapple_foliage::partition::cpu::Threads;
use dapple_foliage::partition::gpu::{CpuUpload, Extractor, Mapping};
use dapple_foliage::partition::{Cells, FULL, FactorPath, quantise_all, reference};
use dapple_gpu::testing::test_gpu;
use dapple_gpu::{Gpu, Targets, wgpu};

const WIDTH: u32 = 128;
const HEIGHT: u32 = 80;

/// A texel a leaf, to which each drawn leaf adds 1.
struct LeafImage {
    pipeline: wgpu::RenderPipeline,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
}

impl LeafImage {
    fn new(gpu: &Gpu) -> Self {
        let format = wgpu::TextureFormat::R8Unorm;
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let texture = gpu.texture("leaves seen", WIDTH, HEIGHT, format, usage).unwrap();
        let view = texture.create_view(&Default::default());
        let module = gpu.module("foliage/leaf_texels.wgsl").unwrap();
        let size = [("TARGET_WIDTH", f64::from(WIDTH)), ("TARGET_HEIGHT", f64::from(HEIGHT))];
        let add = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::One,
            operation: wgpu::BlendOperation::Add,
        };
        let target = wgpu::ColorTargetState {
            format,
            blend: Some(wgpu::BlendState { color: add, alpha: add }),
            write_mask: wgpu::ColorWrites::ALL,
        };
        let pipeline = gpu
            .raster(
                "leaf texels",
                &wgpu::RenderPipelineDescriptor {
                    label: None,
                    layout: None,
                    vertex: wgpu::VertexState {
                        module: &module,
                        entry_point: Some("vertex"),
                        compilation_options: wgpu::PipelineCompilationOptions {
                            constants: &size,
                            ..Default::default()
                        },
                        buffers: &[],
                    },
                    primitive: Default::default(),
                    depth_stencil: None,
                    multisample: Default::default(),
                    fragment: Some(wgpu::FragmentState {
                        module: &module,
                        entry_point: Some("fragment"),
                        compilation_options: Default::default(),
                        targets: &[Some(target)],
                    }),
                    multiview_mask: None,
                    cache: None,
                },
            )
            .unwrap();
        Self { pipeline, texture, view }
    }

    /// How often each texel was drawn to.
    fn seen(
        &self,
        gpu: &Gpu,
        extract: impl FnOnce(&mut dapple_gpu::Frame<'_>),
        draw: impl FnOnce(&mut wgpu::RenderPass<'_>),
    ) -> Vec<u8> {
        let mut frame = gpu.frame();
        extract(&mut frame);
        let colour = [Targets::cleared(&self.view, wgpu::Color::BLACK)];
        frame.raster("draw", Targets { colour: &colour, ..Default::default() }, |pass| {
            pass.set_pipeline(&self.pipeline);
            draw(pass);
        });
        frame.finish().unwrap();
        gpu.read_texture(&self.texture).unwrap()
    }
}

#[test]
fn the_leaves_drawn_are_the_leaves_kept() {
    let Some(gpu) = test_gpu() else { return };
    let image = LeafImage::new(gpu);
    // Fewer leaves than texels: what lies beyond the last leaf must stay untouched.
    let cells = Cells::generate(4, 10_001, 512).unwrap();
    let path = FactorPath { seed: 6, frames: 12 };
    let mut extractors = Mapping::ALL.map(|m| Extractor::new(gpu, &cells, m).unwrap());
    let mut upload = CpuUpload::new(gpu, &cells, Threads::Pool).unwrap();
    for i in [0, 1, 4, 6, 11] {
        let q = quantise_all(&path.factors(&cells, i)).unwrap();
        let mut expected = vec![0_u8; (WIDTH * HEIGHT) as usize];
        for six in reference::extract(&cells, &q).unwrap().indices.chunks_exact(6) {
            expected[(six[0] / 4) as usize] += 1;
        }
        let kept: u32 = expected.iter().map(|&n| u32::from(n)).sum();
        assert!(i != 0 || kept == 10_001);
        for extractor in &mut extractors {
            extractor.set_factors(gpu, &q).unwrap();
            let seen = image.seen(gpu, |f| extractor.record(f), |pass| extractor.draw(pass));
            assert!(seen == expected, "{} frame {i}", extractor.mapping().name());
        }
        upload.extract(gpu, &cells, &q).unwrap();
        let seen = image.seen(gpu, |_| (), |pass| upload.draw(pass));
        assert!(seen == expected, "upload frame {i}");
    }
}

/// The control: factors that are not those of the expectation show in the image.
#[test]
fn one_leaf_more_shows() {
    let Some(gpu) = test_gpu() else { return };
    let image = LeafImage::new(gpu);
    let cells = Cells::with_sizes(4, &[100, 100]).unwrap();
    for mapping in Mapping::ALL {
        let mut extractor = Extractor::new(gpu, &cells, mapping).unwrap();
        let mut seen = |q: [u32; 2]| {
            extractor.set_factors(gpu, &q).unwrap();
            image.seen(gpu, |f| extractor.record(f), |pass| extractor.draw(pass))
        };
        let (a, b) = (seen([FULL, 32_768]), seen([FULL, 33_424]));
        let differing: Vec<_> = (0..a.len()).filter(|&t| a[t] != b[t]).collect();
        assert_eq!(differing, [cells.leaf_ids[150] as usize], "{}", mapping.name());
    }
}

//! Where layers lie, as the shaders want it: numbers, a table, and constants that choose code.

use crate::layered::{
    boundaries::{Boundaries, geometric},
    placement::Placement,
    planes,
    split::SplitFunction,
};
use crate::{Bins, Fragments, Layered, Layout, Opaque, Split, SplitKind};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::wgpu;

/// Shader of the passes that fill layers.
pub(super) const PATH: &str = "opacity-maps/layers.wgsl";

/// Mirrors `LayerParams` of `common/opacity_layers.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct LayerParams {
    layers: u32,
    first: u32,
    end: u32,
    width: u32,
    span: f32,
    lambda: f32,
    stretch: f32,
    octaves: f32,
    write_bias: f32,
    scale: f32,
    last_entry: u32,
    texels: u32,
}

impl LayerParams {
    /// The same for a pass that draws layers `first..end`.
    pub fn of_pass(self, first: u32, end: u32) -> Self {
        Self { first, end, ..self }
    }
}

/// Where layers lie.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    /// Numbers of the shaders; `first` and `end` are those of all layers.
    pub params: LayerParams,
    /// Planes, boundaries, the split's lookup texture, or the λ of tiles; never empty.
    pub table: Vec<f32>,
    /// Constants `LAYOUT`, `SPLIT`, `THESIS_BINS`, `OPAQUE_ALONE` and `TILE`.
    pub constants: [(&'static str, f64); 5],
}

/// What the passes that fill layers read.
pub(super) struct Inputs<'a> {
    pub placed: &'a Placed,
    pub bounds: &'a wgpu::TextureView,
    pub table: &'a wgpu::Buffer,
}

/// Places layers. `fragments` are looked at for planes alone, which an application knows from the
/// boxes around its objects, or from their structure: they are no part of a frame.
pub(super) fn place<E>(
    layered: &Layered,
    opaque: Opaque,
    [width, height]: [u32; 2],
    scale: f32,
    fragments: impl FnOnce() -> Result<Fragments, E>,
) -> Result<Placed, E> {
    let layers = layered.layers;
    let mut params = LayerParams {
        layers,
        end: layers,
        width,
        // Maps of more texels do not fit a texture or a buffer.
        texels: width.saturating_mul(height),
        write_bias: layered.write_bias,
        scale,
        ..LayerParams::default()
    };
    let mut split_kind = 0;
    let mut thesis_bins = false;
    let (layout, table) = match &layered.layout {
        Layout::Planes(slicing) => {
            let n = layers as usize;
            match planes::place(*slicing, n, &fragments()?, opaque, &mut Vec::new()) {
                Placement::Planes { uneven: Some(Boundaries(planes)), .. } => (1, planes),
                Placement::Planes { bounds, uneven: None } => {
                    let (first, last) = (f64::from(bounds.first), f64::from(bounds.last));
                    (0, geometric(first, last, n, 1.0))
                }
                // Planes are placed as planes.
                Placement::Deep { .. } | Placement::Bounded { .. } => (0, vec![0.0; n + 1]),
            }
        }
        Layout::Deep { span, growth, .. } => {
            params.span = *span;
            if *growth == 1.0 {
                (2, vec![0.0])
            } else {
                let (span, growth) = (f64::from(*span), f64::from(*growth));
                (3, geometric(0.0, span, layers as usize, growth))
            }
        }
        Layout::Bounded { split, bins } => {
            thesis_bins = *bins == Bins::Thesis;
            params.lambda = split.lambda;
            params.stretch = split.width as f32 - 2.0;
            params.octaves = (split.width as f32 - 1.0).log2();
            let table = SplitFunction::new(split).table().to_vec();
            split_kind = kind(split);
            (4, if table.is_empty() { vec![0.0] } else { table })
        }
    };
    params.last_entry = table.len() as u32 - 1;
    let opaque_alone = matches!(opaque, Opaque::Weight { in_bounds: false, .. });
    let constants = [
        ("LAYOUT", f64::from(layout)),
        ("SPLIT", f64::from(split_kind)),
        ("THESIS_BINS", f64::from(u8::from(thesis_bins))),
        ("OPAQUE_ALONE", f64::from(u8::from(opaque_alone))),
        ("TILE", 0.0),
    ];
    Ok(Placed { params, table, constants })
}

/// `SPLIT` of the shaders.
fn kind(split: &Split) -> u8 {
    match split.kind {
        SplitKind::Normalised | SplitKind::Positions if split.lambda == 0.0 => 0,
        SplitKind::Normalised => 1,
        SplitKind::Table8 | SplitKind::Table32 => 2,
        SplitKind::Listing => 3,
        SplitKind::Positions => 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shader() {
        crate::gpu::mirror::<LayerParams>(
            PATH,
            "LayerParams",
            &[
                ("layers", 0),
                ("first", 4),
                ("end", 8),
                ("width", 12),
                ("span", 16),
                ("lambda", 20),
                ("stretch", 24),
                ("octaves", 28),
                ("write_bias", 32),
                ("scale", 36),
                ("last_entry", 40),
                ("texels", 44),
            ],
        );
    }
}

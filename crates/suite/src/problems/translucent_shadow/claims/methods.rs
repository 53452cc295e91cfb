//! Settings of the maps as the judges choose them.

use super::super::settings::TABLE_WIDTH;
use dapple_opacity_maps::{
    Bins, Blend, Blur, Code, EndMap, Format, Layered, Layout, Lookup, Model, Opaque, Packing,
    Settings, Slicing, Split, SplitKind, Storage, Taps,
};

/// Side of the map of every figure unless it says otherwise, texels.
pub const RESOLUTION: u32 = 256;

/// A setting of the maps on a grid of texels.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// Thickness of a surface.
    pub model: Model,
    /// Side of the map, texels.
    pub resolution: u32,
    /// The maps.
    pub settings: Settings,
}

impl Method {
    /// The suite's defaults with a code: thickness -ln(1 - alpha), 3 x 3 taps, each decoded, a bias
    /// of 1e-3, opaque casters in a map of their own.
    pub fn of(code: Code) -> Self {
        let settings = Settings { taps: Taps::Box3, bias: 1e-3, ..Settings::plain(code) };
        Self { model: Model::ExpTau, resolution: RESOLUTION, settings }
    }

    /// The same with one tap.
    pub fn one_tap(self) -> Self {
        self.taps(Taps::One)
    }

    /// The same with other taps.
    pub fn taps(mut self, taps: Taps) -> Self {
        self.settings.taps = taps;
        self
    }

    /// The same on another grid.
    pub fn at(mut self, resolution: u32) -> Self {
        self.resolution = resolution;
        self
    }

    /// The same read in another way, where it has layers.
    pub fn lookup(self, lookup: Lookup) -> Self {
        self.with(|layered| layered.lookup = lookup)
    }

    /// The same in another packing, where it has layers.
    pub fn packing(self, packing: Packing) -> Self {
        self.with(|layered| layered.packing = packing)
    }

    /// The same with something else about its layers, where it has some.
    pub fn with(mut self, change: impl FnOnce(&mut Layered)) -> Self {
        if let Code::Layered(layered) = &mut self.settings.code {
            change(layered);
        }
        self
    }

    /// Layers K, 0 for what has none.
    pub fn layers(&self) -> usize {
        match &self.settings.code {
            Code::Layered(layered) => layered.layers as usize,
            _ => 0,
        }
    }
}

/// K layers of a layout, interpolated, added up in 32-bit floats.
pub fn layered(layout: Layout, layers: u32) -> Method {
    Method::of(Code::Layered(Layered {
        layout,
        layers,
        lookup: Lookup::Lerp,
        write_bias: 0.0,
        soft_start: false,
        blend: Blend::Add,
        format: Format::F32,
        packing: Packing::Targets(8),
        storage: Storage::Blend,
        end_map: EndMap::MaxBlend,
    }))
}

/// Opacity shadow maps: even planes.
pub fn osm(layers: u32) -> Method {
    layered(Layout::Planes(Slicing::Uniform), layers)
}

/// Deep opacity maps of even layers, `span` of the light's depth range deep.
pub fn dom(layers: u32, span: f32) -> Method {
    layered(Layout::Deep { span, growth: 1.0, listing: false }, layers)
}

/// Bounding opacity maps of even layers.
pub fn bom(layers: u32) -> Method {
    bom_split(layers, 0.0, SplitKind::Normalised)
}

/// Bounding opacity maps with a split function.
pub fn bom_split(layers: u32, lambda: f32, kind: SplitKind) -> Method {
    let split = Split { lambda, kind, width: TABLE_WIDTH };
    layered(Layout::Bounded { split, bins: Bins::Full }, layers)
}

/// The thesis's bins, K - 1 of them, with the fragments' depths biased as the receivers'.
pub fn thesis_bins(method: Method) -> Method {
    let bias = method.settings.bias;
    method.with(|layered| {
        layered.write_bias = bias;
        if let Layout::Bounded { bins, .. } = &mut layered.layout {
            *bins = Bins::Thesis;
        }
    })
}

/// Everything else of the thesis: thickness is alpha, the layer's own sum is read, sums are
/// averaged before they are decoded, opaque casters weigh 3.
pub fn thesis_reading(method: Method) -> Method {
    let mut method = method.lookup(Lookup::Nearest);
    method.model = Model::ExpAlpha;
    method.settings.blur = Blur::Stored;
    method.settings.opaque = Opaque::Weight { weight: 3.0, in_bounds: false };
    method
}

/// Shares of the deepest ray that deep opacity maps are tried over.
pub const SPANS: [f32; 8] = [0.03, 0.06, 0.12, 0.25, 0.5, 1.0, 1.5, 3.0];

/// All ways of reading layers.
pub const LOOKUPS: [Lookup; 3] = [Lookup::Lerp, Lookup::Nearest, Lookup::Exclusive];

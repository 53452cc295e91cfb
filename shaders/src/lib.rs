//! The WGSL of every technique, embedded, resolved, and checked by naga.
//!
//! Files live in `<crate>/<stage>.wgsl` beside this crate's manifest; what several share lives in
//! `common/`. To add one: put the file, and add one line to [`FILES`].

mod layout;
mod resolve;

pub use layout::{Layout, struct_layout, validate};
pub use resolve::ShaderError;

macro_rules! files {
    ($($path:literal,)*) => { &[$(($path, include_str!(concat!("../", $path))),)*] };
}

/// Every embedded file: path under `shaders/`, text as written (imports not resolved).
pub const FILES: &[(&str, &str)] = files![
    "common/channels.wgsl",
    "common/index.wgsl",
    "common/kept_counts.wgsl",
    "common/partition.wgsl",
    "foliage/leaf_texels.wgsl",
    "foliage/multi_draw.wgsl",
    "foliage/reduce.wgsl",
    "foliage/scan.wgsl",
    "foliage/thread_per_cell.wgsl",
    "foliage/thread_per_leaf.wgsl",
    "foliage/workgroup_per_cell.wgsl",
    "common/moments.wgsl",
    "common/hash.wgsl",
    "common/lights.wgsl",
    "common/lights_cells.wgsl",
    "common/lights_draw.wgsl",
    "common/lights_frame.wgsl",
    "common/lights_random.wgsl",
    "common/lights_rule.wgsl",
    "common/lights_shadow.wgsl",
    "common/lights_stochastic.wgsl",
    "common/lights_sum.wgsl",
    "common/lights_tree.wgsl",
    "common/occlusion_cull.wgsl",
    "common/occlusion_scene.wgsl",
    "common/occlusion_view.wgsl",
    "common/opacity_bounds.wgsl",
    "common/opacity_each.wgsl",
    "common/opacity_fourier.wgsl",
    "common/opacity_lanes.wgsl",
    "common/opacity_layers.wgsl",
    "common/opacity_moments.wgsl",
    "common/opacity_number.wgsl",
    "common/opacity_read.wgsl",
    "common/opacity_score.wgsl",
    "common/opacity_series.wgsl",
    "common/opacity_series_read.wgsl",
    "common/opacity_surface.wgsl",
    "common/opacity_taps.wgsl",
    "common/opacity_targets.wgsl",
    "common/precise.wgsl",
    "common/shadow_rays.wgsl",
    "common/visibility.wgsl",
    "common/window.wgsl",
    "gpu/arithmetic.wgsl",
    "gpu/copy.wgsl",
    "gpu/f16_store.wgsl",
    "gpu/loops.wgsl",
    "gpu/triangle.wgsl",
    "gpu/work.wgsl",
    "many-lights/brute_force.wgsl",
    "many-lights/capped.wgsl",
    "many-lights/clustered_cells.wgsl",
    "many-lights/clustered_clear.wgsl",
    "many-lights/clustered_light.wgsl",
    "many-lights/clustered_list.wgsl",
    "many-lights/cut.wgsl",
    "many-lights/cut_tile.wgsl",
    "many-lights/light_bvh.wgsl",
    "many-lights/lightcuts.wgsl",
    "many-lights/reservoirs.wgsl",
    "many-lights/stochastic.wgsl",
    "many-lights/stochastic_tile.wgsl",
    "many-lights/shadow_rays.wgsl",
    "occlusion/boxes.wgsl",
    "occlusion/draw.wgsl",
    "occlusion/hierarchical_cull.wgsl",
    "occlusion/hierarchical_list.wgsl",
    "occlusion/hierarchical_pyramid.wgsl",
    "opacity-maps/bounds.wgsl",
    "opacity-maps/fourier.wgsl",
    "opacity-maps/fragments.wgsl",
    "opacity-maps/join_bounds.wgsl",
    "opacity-maps/layers.wgsl",
    "opacity-maps/moments.wgsl",
    "opacity-maps/opaque.wgsl",
    "opacity-maps/place.wgsl",
    "opacity-maps/prefix.wgsl",
    "opacity-maps/search_bins.wgsl",
    "opacity-maps/search_decide.wgsl",
    "opacity-maps/search_targets.wgsl",
    "opacity-maps/shade_bins.wgsl",
    "opacity-maps/shade_fourier.wgsl",
    "opacity-maps/shade_lit.wgsl",
    "opacity-maps/shade_moments.wgsl",
    "opacity-maps/shade_nearest.wgsl",
    "opacity-maps/shade_survivors.wgsl",
    "opacity-maps/shade_targets.wgsl",
    "opacity-maps/survivors.wgsl",
    "shadows/cascade.wgsl",
    "shadows/depth.wgsl",
    "shadows/depth_copy.wgsl",
    "shadows/filter_x.wgsl",
    "shadows/filter_y.wgsl",
    "shadows/pack.wgsl",
    "shadows/shade.wgsl",
];

/// The text of `path` (for example `"shadows/box.wgsl"`) with its imports put in.
///
/// A line `#import common/index.wgsl` is replaced by that file's text, each file once,
/// depth-first. `enable` directives of imported files are moved to the top, where WGSL wants them.
///
/// # Errors
/// [`ShaderError::Unknown`] and [`ShaderError::Cycle`], naming file and line.
pub fn source(path: &str) -> Result<String, ShaderError> {
    resolve::resolve(path, &|path| raw(path))
}

/// The files that hold entry points: all but `common/`.
pub fn paths() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(path, _)| *path).filter(|path| !path.starts_with("common/"))
}

/// Hash over all paths and texts, 16 hex digits: goes into every record.
pub fn hash() -> String {
    let mut sorted: Vec<_> = FILES.to_vec();
    sorted.sort_unstable();
    let mut hasher = blake3::Hasher::new();
    for (path, text) in sorted {
        for part in [path, text] {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part.as_bytes());
        }
    }
    hasher.finalize().to_hex()[..16].to_string()
}

fn raw(path: &str) -> Option<&'static str> {
    FILES.iter().find(|(known, _)| *known == path).map(|(_, text)| *text)
}

//! The fragments that this device rasterises, texel by texel.
//!
//! Two passes over the geometry: the first counts, the second writes from where each texel starts.
//! Which invocation comes first is the device's affair, so the fragments of a texel are put in
//! order of depth, and of thickness among equal depths. Differences from fragments by rays are the
//! rasteriser's: its sub-pixel step at edges, and the rounding of interpolated depths.

use super::{
    OpacityGpuError,
    bounds::{Bounds, Ends},
    raster::Raster,
    stage::Stage,
};
use crate::{EndMap, Fragment, Fragments, Model, NO_OPAQUE, Opaque};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::bindings::{Slot, bind, layout, whole};
use dapple_gpu::{Frame, Gpu, light_space::LightSpaceMesh, wgpu};

/// Mirrors `ListParams` of `opacity-maps/fragments.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ListParams {
    width: u32,
    pad: [u32; 3],
}

/// Rasterises the mesh at `size` (width, height) and reads every fragment back.
///
/// # Errors
/// An empty map, an unsound mesh, more fragments than a buffer of the device holds, a lost device.
pub fn fragments(
    gpu: &Gpu,
    mesh: &LightSpaceMesh,
    model: Model,
    size: [u32; 2],
) -> Result<Fragments, OpacityGpuError> {
    let raster = Raster::new(gpu, mesh, model, size, Opaque::Separate)?;
    of(gpu, &raster)
}

/// The fragments of a mesh that is there already.
pub(super) fn of(gpu: &Gpu, raster: &Raster) -> Result<Fragments, OpacityGpuError> {
    let texels = raster.width as usize * raster.height as usize;
    let slots = layout(gpu, "fragment lists", &[Slot::Uniform, Slot::Write, Slot::Write]);
    let params = gpu.uniform("fragment lists", &ListParams { width: raster.width, pad: [0; 3] })?;
    let run = |entry: &'static str, places: &wgpu::Buffer, items: &wgpu::Buffer| {
        let stage = Stage {
            path: "opacity-maps/fragments.wgsl",
            entry,
            constants: &[],
            pass: Some(&slots),
            targets: &[],
            depth: None,
            swapped: false,
            opaque_joins: false,
        };
        let pipelines = raster.pipelines(gpu, &stage)?;
        let group = bind(gpu, &slots, &[whole(&params), whole(places), whole(items)]);
        let mut frame: Frame<'_> = gpu.frame();
        raster.record_opaque(&mut frame);
        frame.raster(entry, raster.no_targets(), |pass| raster.draw(pass, &pipelines, &group));
        frame.finish().map(|_| ())
    };
    let counts = gpu.upload("fragment counts", &vec![0u32; texels])?;
    run("count", &counts, &gpu.buffer("no items", 16)?)?;
    let counts: Vec<u32> = gpu.read(&counts, 0, texels)?;
    let mut starts = Vec::with_capacity(texels + 1);
    let mut end = 0u64;
    for count in &counts {
        // A buffer that holds them is refused below before a start could wrap.
        starts.push(end as u32);
        end += u64::from(*count);
    }
    let items = gpu.buffer("fragments", 8 * end)?;
    let places = gpu.upload("places of fragments", &starts)?;
    starts.push(end as u32);
    run("write", &places, &items)?;
    let mut items: Vec<Fragment> = gpu.read(&items, 0, end as usize)?;
    for texel in starts.windows(2) {
        // Depths and thicknesses are not negative: their bits order as they do.
        items[texel[0] as usize..texel[1] as usize]
            .sort_unstable_by_key(|f| (f.depth.to_bits(), f.omega.to_bits()));
    }
    let opaque = nearest_opaque(gpu, raster)?;
    let all = Fragments { width: raster.width, height: raster.height, starts, items, opaque };
    all.check()?;
    Ok(all)
}

/// The first and the last translucent fragment of each texel, the rest left out; thickness is none.
pub(super) fn extremes(gpu: &Gpu, raster: &Raster) -> Result<Fragments, OpacityGpuError> {
    let bounds = Bounds::new(gpu, raster, Ends::Both(EndMap::MaxBlend), false)?;
    let mut frame = gpu.frame();
    raster.record_opaque(&mut frame);
    bounds.record(&mut frame, raster);
    frame.finish()?;
    let (mut starts, mut items) = (vec![0], Vec::new());
    for [first, last] in bounds.read(gpu)? {
        if first <= last {
            items.extend([first, last].map(|depth| Fragment { depth, omega: 0.0 }));
        }
        starts.push(items.len() as u32);
    }
    let opaque = nearest_opaque(gpu, raster)?;
    Ok(Fragments { width: raster.width, height: raster.height, starts, items, opaque })
}

fn nearest_opaque(gpu: &Gpu, raster: &Raster) -> Result<Vec<f32>, OpacityGpuError> {
    let mut opaque = gpu.read_f32(raster.opaque_map())?;
    opaque.iter_mut().filter(|z| **z >= 1.0).for_each(|z| *z = NO_OPAQUE);
    Ok(opaque)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shader() {
        crate::gpu::mirror::<ListParams>(
            "opacity-maps/fragments.wgsl",
            "ListParams",
            &[("width", 0), ("pad0", 4), ("pad1", 8), ("pad2", 12)],
        );
    }
}

// Sums of fixed-point bins from the light on, clipping at the greatest number.
#import common/index.wgsl

struct PrefixParams {
    texels: u32,
    layers: u32,
    pad0: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> sizes: PrefixParams;
// One map of `texels` after the other.
@group(0) @binding(1) var<storage, read_write> bins: array<u32>;
// 256 less the first bin of a texel that ran over, 0 where none did.
@group(0) @binding(2) var<storage, read> overrun: array<u32>;

const MOST = 0xffffffffu;

@compute @workgroup_size(64)
fn prefix(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let texel = linear_index(id, groups, 64u);
    if texel >= sizes.texels {
        return;
    }
    let clipped_from = 256u - overrun[texel];
    var sum = 0u;
    for (var layer = 0u; layer < sizes.layers; layer++) {
        let at = layer * sizes.texels + texel;
        let next = sum + bins[at];
        sum = select(next, MOST, next < sum || layer >= clipped_from);
        bins[at] = sum;
    }
}

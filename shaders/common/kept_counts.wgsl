// Leaves kept of each cell; dapple-foliage's `kept`, to the bit.
// Based on: Gumbau Portales, PhD thesis, Universitat Jaume I, 2011, section 3.4.2.
#import common/partition.wgsl

// Cells that one workgroup of the prefix sum handles: ITEMS neighbouring ones a lane.
const ITEMS = 8u;
const TILE = 2048u; // LANES * ITEMS

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> starts: array<u32>;
@group(0) @binding(2) var<storage, read> factors_q: array<u32>;

// No overflow: 65535 * 65535 + 32767 < 2^32, and 1048831 * 4095 + 2047 < 2^32, the largest cell
// there is (the host refuses larger ones).
fn kept(n: u32, q: u32) -> u32 {
    if n <= 65535u {
        return (n * q + 32767u) / 65535u;
    }
    let coarse = (q * 4095u + 32767u) / 65535u;
    return (n * coarse + 2047u) / 4095u;
}

// Of cell `c`; 0 beyond the last.
fn kept_of(c: u32) -> u32 {
    if c >= params.n_cells {
        return 0u;
    }
    return kept(starts[c + 1u] - starts[c], factors_q[c]);
}

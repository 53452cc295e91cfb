// Probe: does a loop run as often as asked, and does a second loop get its own count?
// in: iterations of loop 1, of loop 2. out: count and generator state after each.
@group(0) @binding(0) var<storage, read_write> asked: array<u32>;
@group(0) @binding(1) var<storage, read_write> seen: array<u32>;

// The generator's state depends on every step, so that no compiler can fold the loop away.
fn next(x: u32) -> u32 {
    return x * 1664525u + 1013904223u;
}

@compute @workgroup_size(1)
fn count_iterations() {
    var x = 1u;
    var n = 0u;
    for (var i = 0u; i < asked[0]; i++) {
        x = next(x);
        n++;
    }
    seen[0] = n;
    seen[1] = x;
    x = 1u;
    n = 0u;
    for (var i = 0u; i < asked[1]; i++) {
        x = next(x);
        n++;
    }
    seen[2] = n;
    seen[3] = x;
}

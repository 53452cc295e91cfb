// Sums of very many small numbers: blocks, then blocks of blocks, since one running 32-bit float
// would lose what is added late.

// Numbers of a block: with 10^6 lights there are as many blocks as lights in one.
const BLOCK = 1024u;

struct Sum {
    total: vec3<f32>,
    held: u32,
    block: vec3<f32>,
}

fn no_sum() -> Sum {
    return Sum(vec3<f32>(0.0), 0u, vec3<f32>(0.0));
}

fn added(sum: Sum, value: vec3<f32>) -> Sum {
    let block = sum.block + value;
    if sum.held + 1u == BLOCK {
        return Sum(sum.total + block, 0u, vec3<f32>(0.0));
    }
    return Sum(sum.total, sum.held + 1u, block);
}

fn result_of(sum: Sum) -> vec3<f32> {
    return sum.total + sum.block;
}

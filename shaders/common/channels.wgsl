// A stored word of a filtered map: one f32 channel, or two 16-bit ones. FORMAT is explicit here,
// not a texture format, so that rounding is the same on every adapter.
const FORMAT_F32 = 0u;
const FORMAT_F16 = 1u;
const FORMAT_U16 = 2u;
override FORMAT: u32 = 0u;

// floor(65535 x + 1/2) of 0 <= x <= 1. 65536 x and its fraction are exact, and so are the sums
// beside the comparisons wherever they decide: 65535 x itself would move depths across a step's
// border, and fraction - x would be rounded onto it.
fn integer_step(x: vec2<f32>) -> vec2<u32> {
    let whole = floor(x * 65536.0);
    let fraction = x * 65536.0 - whole;
    let up = select(vec2(0.0), vec2(1.0), fraction - 0.5 >= x);
    let down = select(vec2(0.0), vec2(1.0), x > fraction + 0.5);
    return vec2<u32>(whole + up - down);
}

// Rounds to nearest even in half floats, half up in integers. f32 keeps `v.x` alone.
fn encode(v: vec2<f32>) -> u32 {
    if FORMAT == FORMAT_F32 {
        return bitcast<u32>(v.x);
    }
    if FORMAT == FORMAT_F16 {
        return pack2x16float(v);
    }
    let q = integer_step(clamp(v, vec2(0.0), vec2(1.0)));
    return q.x | (q.y << 16u);
}

fn decode(word: u32) -> vec2<f32> {
    if FORMAT == FORMAT_F32 {
        return vec2(bitcast<f32>(word), 0.0);
    }
    if FORMAT == FORMAT_F16 {
        return unpack2x16float(word);
    }
    return vec2(f32(word & 0xffffu), f32(word >> 16u)) / 65535.0;
}

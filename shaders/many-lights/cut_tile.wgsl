// R4 with one cut for the pixels of a tile that start alike: bounds are over all of them, so no lane
// waits for another.
// Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 3.1 and 3.2.
// Deviations: the cut of a tile is ours.
// Every lane walks the same way and bounds the same region by itself: lanes in step pay nothing for
// that, and a walk needs no barrier.
#import common/lights_rule.wgsl
#import common/lights_shadow.wgsl

const LANES = TILE * TILE;

var<workgroup> tile_points: array<Point, LANES>;
var<workgroup> tile_ranges: array<vec2<u32>, LANES>;

// Whether pixel `lane` of the tile shows something that starts as `range` does.
fn is_alike(lane: u32, range: vec2<u32>) -> bool {
    return tile_points[lane].object != NOTHING && all(tile_ranges[lane] == range);
}

// The least region around the tile's points that start alike, in the order of PackedRegion::of.
fn region_of(range: vec2<u32>) -> Region {
    var region: Region;
    var first = true;
    for (var lane = 0u; lane < LANES; lane++) {
        if !is_alike(lane, range) {
            continue;
        }
        let one = tile_points[lane];
        if first {
            region.low = one.position;
            region.high = one.position;
            region.normal_axis = one.normal;
            region.albedo = one.albedo;
        } else {
            region.low = min(region.low, one.position);
            region.high = max(region.high, one.position);
            region.normal_axis += one.normal;
            region.albedo = max(region.albedo, one.albedo);
        }
        first = false;
    }
    let squared = dot(region.normal_axis, region.normal_axis);
    if squared == 0.0 {
        region.normal_axis = vec3<f32>(0.0, 0.0, 1.0);
        region.normal_spread_rad = WHOLE_CONE;
        return region;
    }
    region.normal_axis *= 1.0 / sqrt(squared);
    var spread = 0.0;
    for (var lane = 0u; lane < LANES; lane++) {
        if is_alike(lane, range) {
            spread = max(spread, angle_between(region.normal_axis, tile_points[lane].normal));
        }
    }
    region.normal_spread_rad = spread;
    return region;
}

@compute @workgroup_size(TILE, TILE)
fn light(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let inside = is_inside(id.xy);
    let pixel = index_of(id.xy);
    tile_points[lane].object = NOTHING;
    if inside {
        tile_points[lane] = points[pixel];
        tile_ranges[lane] = range_of(points[pixel].object);
    }
    workgroupBarrier();
    if !inside {
        return;
    }
    let point = tile_points[lane];
    var sum = no_sum();
    // Visits, bounds, lights, nodes of the cut.
    var counted = vec4<u32>(0u);
    if point.object != NOTHING {
        let range = tile_ranges[lane];
        let region = region_of(range);
        for (var s = range.x; s <= range.y; s++) {
            let walk = walk_of(s, range.y, region.high.y);
            let hidden = s < range.y && is_start_hidden(s, point.position.y);
            var i = walk.x;
            while i < walk.y {
                let node = nodes[i];
                let leaf = node.size == 1u;
                var taken = leaf;
                if !leaf {
                    taken = is_taken(bound_region(FORM, node, region, frame.clamp_squared), 0.0);
                }
                if taken {
                    let whole = estimate(node, point, frame.clamp_squared);
                    let given = select(whole, vec3<f32>(0.0), hidden);
                    sum = added(sum, seen(point, node.light, given));
                }
                if COUNT {
                    counted += vec4<u32>(vec4<bool>(true, !leaf, leaf, taken));
                }
                i += select(1u, node.size, taken);
            }
        }
        if COUNT {
            // One bound serves all that start alike.
            for (var before = 0u; before < lane; before++) {
                if is_alike(before, range) {
                    counted.y = 0u;
                }
            }
        }
    }
    radiance[pixel] = vec4<f32>(result_of(sum), f32(rays));
    if COUNT {
        counts[pixel] = counted;
    }
}

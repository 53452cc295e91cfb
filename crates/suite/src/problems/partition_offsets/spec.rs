//! What the problem declares.

use crate::{
    knob::Knob,
    problem::{Constraint, Form, Metric, Spec, Technique, Variant},
};

/// Generator's name for crowns that need no file.
pub const CROWN: &str = "crown";

const PLAIN: &[Variant] = &[Variant { id: "plain", help: "as described", not_in: &[] }];
const CPU: &[Form] = &[Form::Cpu];
const GPU: &[Form] = &[Form::Gpu];

const fn technique(id: &'static str, title: &'static str, forms: &'static [Form]) -> Technique {
    Technique { id, title, source: "gumbau2011", forms, variants: PLAIN, knobs: &[] }
}

/// The declaration.
pub const SPEC: Spec = Spec {
    id: "partition-offsets",
    title: "Partition offsets and index generation for pruned foliage",
    question: "Which way of packing the kept leaves of every cell moves the fewest bytes?",
    truth: "the scalar prefix sum and copy, and a validator that trusts no form",
    metrics: &[
        Metric {
            name: "bytes_per_leaf",
            unit: "B",
            help: "bytes read and written for each leaf kept, over the path (28 is a bare copy)",
        },
        Metric {
            name: "wrong_frames",
            unit: "frames",
            help: "frames whose ranges or indices differ from the reference in any bit",
        },
    ],
    axis: "bytes_per_leaf",
    constraints: &[Constraint { metric: "wrong_frames", limit: 0.0 }],
    levels: [32.0, 48.0, 96.0],
    pictures: false,
    parameters: &[
        Knob::int("leaves", [0, 131_042, 10_000_000], "leaves of a generated crown")
            .log()
            .useful(2048.0, 2e6),
        Knob::int("cells", [1, 512, 100_000], "cells that the leaves are sorted into")
            .log()
            .useful(16.0, 32_768.0),
        Knob::int("frames", [1, 24, 1000], "frames of the path on which the factors change")
            .useful(1.0, 48.0),
    ],
    default_scene: CROWN,
    techniques: &[
        technique("thread-per-cell", "One thread copies one cell (as in the thesis)", GPU),
        technique("workgroup-per-cell", "One workgroup copies one cell", GPU),
        technique(
            "thread-per-leaf",
            "One thread writes one kept leaf, found by binary search",
            GPU,
        ),
        technique("multi-draw", "No copy: one indirect draw a cell over the static indices", GPU),
        technique("cpu-upload", "One processor thread packs, the indices are uploaded whole", GPU),
        technique("cpu-thread", "One processor thread packs", CPU),
        technique("cpu-threads", "All processor threads pack chunks of equal length", CPU),
    ],
};

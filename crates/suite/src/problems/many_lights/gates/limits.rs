//! Where each technique leaves nothing out.

use crate::SuiteError;
use serde_json::{Value, json};

/// Settings with which a technique is exact, and some with which it is not.
pub struct Limit {
    /// Exact.
    pub exact: Vec<(&'static str, Value)>,
    /// Not so; empty where there is nothing to set.
    pub loose: Vec<(&'static str, Value)>,
    /// Whether it takes a world of one light to be exact.
    pub lone: bool,
}

/// The limit of a technique's variant. A new technique has to state its own.
///
/// # Errors
/// [`SuiteError::Internal`] for a technique without one.
pub fn limit(technique: &str, variant: &str) -> Result<Limit, SuiteError> {
    let of = |exact, loose| Limit { exact, loose, lone: false };
    let alone = |knobs: Vec<(&'static str, Value)>| Limit {
        exact: knobs.clone(),
        loose: knobs,
        lone: true,
    };
    Ok(match technique {
        "brute-force" => of(vec![], vec![]),
        "lightcuts" => of(
            vec![("epsilon", json!(0.0)), ("most", json!(16_384))],
            vec![("epsilon", json!(1.0)), ("most", json!(1))],
        ),
        "relative-cut" => {
            of(vec![("own_epsilon", json!(0.0))], vec![("own_epsilon", json!(100.0))])
        }
        "absolute-cut" => of(vec![("threshold", json!(0.0))], vec![("threshold", json!(1.0))]),
        // A cluster that gives nothing where the tile's cut is made stays whole.
        "stochastic-lightcuts" if variant == "real-time" => alone(vec![]),
        "light-bvh" => alone(vec![]),
        "stochastic-lightcuts" => of(vec![("cut", json!(1024))], vec![("cut", json!(1))]),
        "reservoirs" => alone(vec![("temporal", json!("off")), ("neighbours", json!(0))]),
        "clustered" => of(vec![("cutoff", json!(1e-9))], vec![("cutoff", json!(1.0))]),
        "capped" => of(vec![("most", json!(1_000_000))], vec![("most", json!(1))]),
        name => return Err(SuiteError::Internal(format!("no limit is stated for {name}"))),
    })
}

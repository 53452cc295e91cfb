//! What light that leaks through walls is bought back for.

use super::{
    support::{checked, counter, error, ns, prepared, setting},
    verdict::{figure, judged, vote, vote_open},
};
use crate::{
    SuiteError,
    claims::{Claim, Judged},
};
use serde_json::{Value, json};

/// Views whose frames are compared: from above takes too long for shadow rays from all lights.
const VIEWS: [&str; 3] = ["facade", "close_ended", "street"];

/// Columns: shadow rays of whole images are many.
const WIDTH: u32 = 64;

/// Repeats of a frame that is timed.
const REPEATS: usize = 3;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "conte-7-leak",
            statement: "Lights kept though hidden from the pixel are the largest error",
            place: "Conte 2018, sections 5.3 and 6.1: no shadows by pixel",
            method: "three views of the 6 x 6 city, 64 x 48, defaults: greatest leak over the greatest \
                     of the other causes (hidden: 0; weak; clusters). Met in a view where it is twice \
                     the others or more, contradicted where it is less than them",
            judge: Box::new(|_| largest()),
        },
        Claim {
            id: "conte-6.1-shadow-rays",
            statement: "A shadow ray for each cluster of a pixel's cut buys back what leaks",
            place: "Conte 2018, section 6.1: shadows by pixel are left out",
            method: "the same with shadow rays off and on. Met in a view if the mean leak falls to a \
                     tenth or less: what is left is of clusters whose one ray arrives where not all of \
                     their lights do. The price is told: times the frame, and rays a pixel",
            judge: Box::new(|_| bought()),
        },
        Claim {
            id: "conte-6.1-shadow-rays-price",
            statement: "Precuts make images with shadow rays cheaper than cuts of all lights with them",
            place: "question of this project",
            method: "the same with shadow rays on, over shadow rays on cuts of all lights: rays decide, \
                     as they are most of the time of either. Met in a view where precuts cast fewer than \
                     half; contradicted where they cast as many. Times of first frames stand beside, \
                     median of three",
            judge: Box::new(|_| cheaper()),
        },
    ]
}

fn with_rays() -> [(&'static str, Value); 1] {
    [("shadow_rays", json!("on"))]
}

fn given() -> [(&'static str, Value); 1] {
    [("width", json!(WIDTH))]
}

/// Greatest leak, and the greatest of the other causes.
fn is_largest(leak: f64, others: f64) -> Option<bool> {
    if leak >= 2.0 * others {
        Some(true)
    } else if leak >= others {
        None
    } else {
        Some(false)
    }
}

fn largest() -> Result<Judged, SuiteError> {
    let (mut figures, mut cases, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for view in VIEWS {
        let case = prepared("city", view, &given())?;
        let run = checked(&case, "facade-cluster", &[])?;
        let causes = ["e_cull", "e_irr", "e_cut", "e_leak"];
        let found = causes.map(|name| error(&run, name));
        figures.extend(
            causes
                .into_iter()
                .zip(found)
                .map(|(name, value)| figure(format!("{view}: {name}"), value, "")),
        );
        let others = found[..3].iter().copied().fold(0.0, f64::max);
        told.push(format!("{:.1}", found[3] / others.max(f64::MIN_POSITIVE)));
        cases.push(is_largest(found[3], others));
    }
    let because = format!("leaks are {} times the next greatest cause", told.join(", "));
    Ok(judged(vote_open(&cases), because, figures))
}

fn bought() -> Result<Judged, SuiteError> {
    let (mut figures, mut cases, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for view in VIEWS {
        let case = prepared("city", view, &given())?;
        let off = checked(&case, "facade-cluster", &[])?;
        let on = checked(&case, "facade-cluster", &with_rays())?;
        let times = [&[][..], &with_rays()[..]]
            .map(|knobs| ns(&case, &setting("facade-cluster", knobs)?, REPEATS));
        let [time_off, time_on] = times;
        let price = time_on? / time_off?.max(1.0);
        let leaks = [error(&off, "leak"), error(&on, "leak")];
        let rays = counter(&on, "shadow_rays") / f64::from(WIDTH * WIDTH * 3 / 4);
        figures.extend([
            figure(format!("{view}: leak over truth, off"), leaks[0], ""),
            figure(format!("{view}: leak over truth, on"), leaks[1], ""),
            figure(format!("{view}: error_p99, off"), error(&off, "error_p99"), ""),
            figure(format!("{view}: error_p99, on"), error(&on, "error_p99"), ""),
            figure(format!("{view}: rays a pixel"), rays, ""),
            figure(format!("{view}: time, on over off"), price, "times"),
        ]);
        told.push(format!("{:.4} to {:.4} for {price:.1} times the frame", leaks[0], leaks[1]));
        cases.push(is_bought(leaks));
    }
    Ok(judged(vote(&cases), format!("leaks fall from {}", told.join(", ")), figures))
}

fn is_bought([off, on]: [f64; 2]) -> bool {
    on <= 0.1 * off
}

/// Rays from precuts over rays from all lights.
fn is_cheaper(rays: f64) -> Option<bool> {
    if rays < 0.5 {
        Some(true)
    } else if rays < 1.0 {
        None
    } else {
        Some(false)
    }
}

fn cheaper() -> Result<Judged, SuiteError> {
    let (mut figures, mut cases, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for view in VIEWS {
        let case = prepared("city", view, &given())?;
        let own = checked(&case, "facade-cluster", &with_rays())?;
        let all = checked(&case, "traced-cut", &[])?;
        let rays = counter(&own, "shadow_rays") / counter(&all, "shadow_rays").max(1.0);
        let one = ns(&case, &setting("facade-cluster", &with_rays())?, REPEATS)?;
        let other = ns(&case, &setting("traced-cut", &[])?, REPEATS)?;
        figures.extend([
            figure(format!("{view}: rays, precuts over all lights"), rays, "times"),
            figure(format!("{view}: time, precuts over all lights"), one / other.max(1.0), "times"),
        ]);
        told.push(format!("{rays:.2}"));
        cases.push(is_cheaper(rays));
    }
    let because = format!("precuts cast {} times the rays", told.join(", "));
    Ok(judged(vote_open(&cases), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaks_are_largest_or_not() {
        let of = |leak| is_largest(leak, 1.0);
        assert_eq!([2.0, 1.5, 0.5].map(of), [Some(true), None, Some(false)]);
        assert_eq!(of(f64::NAN), Some(false));
    }

    #[test]
    fn leaks_are_bought_back_or_not() {
        assert!(is_bought([0.2, 0.02]) && !is_bought([0.2, 0.03]) && !is_bought([0.2, f64::NAN]));
    }

    #[test]
    fn precuts_are_cheaper_or_not() {
        let of = [0.4, 0.7, 1.0, f64::NAN].map(is_cheaper);
        assert_eq!(of, [Some(true), None, Some(false), Some(false)]);
    }
}

use crate::claims::Claim;

pub fn claims() -> Vec<Claim> {
    Vec::new()
}

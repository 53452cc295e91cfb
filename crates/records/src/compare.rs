//! Two runs, row by row: what got faster, slower, better or worse beyond noise.

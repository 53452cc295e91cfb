//! dapple-records

//! Records of several machines or shards as one file.

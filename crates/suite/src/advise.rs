//! Which technique and setting is the cheapest that is good enough, from as few measurements as will do.

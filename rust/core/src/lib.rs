//! Planning and belief arithmetic of beltsort: sorting objects from a conveyor belt by active perception.

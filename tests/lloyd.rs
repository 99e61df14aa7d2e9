//! Tests of lloyd.

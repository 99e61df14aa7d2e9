//! Only relocation.
#![allow(dead_code)]
mod support;
mod relocation;

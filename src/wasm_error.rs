//! Errors as JavaScript has them.

use crate::error::Error;
use wasm_bindgen::prelude::*;

/// A JavaScript `Error` whose name is the error's kind.
pub fn thrown(e: Error) -> JsValue {
    let error = js_sys::Error::new(&e.to_string());
    error.set_name(e.kind());
    error.into()
}

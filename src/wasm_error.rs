//! Errors as JavaScript has them, and panics, which are errors of our own.

use crate::error::Error;
use wasm_bindgen::prelude::*;

/// A JavaScript `Error` whose name is the error's kind.
pub fn thrown(e: Error) -> JsValue {
    let error = js_sys::Error::new(&e.to_string());
    error.set_name(e.kind());
    error.into()
}

#[wasm_bindgen]
extern "C" {
    /// The browser adds from where it was called.
    #[wasm_bindgen(js_namespace = console)]
    fn error(text: &str);
}

/// What is said of a panic goes to the browser's console. Else it would be an `unreachable` without a word.
pub fn tell_of_panics() {
    std::panic::set_hook(Box::new(|panic| error(&panic.to_string())));
}

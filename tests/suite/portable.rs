//! Files are the same on every machine and in wasm, where tests/wasm_encode.rs checks the same hashes.

#[path = "../fixtures/portable.rs"]
mod picture;

#[test]
fn files_are_the_same_on_every_machine_and_any_number_of_threads() {
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let files = pool.install(|| [0, 1, 2, 3].map(picture::file));
        assert_eq!(files, picture::FILES, "{threads} threads");
        assert_eq!(pool.install(picture::labels), picture::LABELS, "{threads} threads");
    }
}

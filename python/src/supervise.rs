//! Long work beside the interpreter: the GIL is free, Ctrl-C reaches the work, and progress reaches Python.

use crate::error::Failure;
use exid::problem::defect::guarded;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// From one look for Ctrl-C to the next.
const LOOK: Duration = Duration::from_millis(50);

/// Memory of the stack that work has in the program, bytes.
const STACK: usize = 8 << 20;

/// What watches over work.
pub struct Supervisor {
    /// Called with what is going on, in words.
    pub progress: Option<Py<PyAny>>,
    /// Set by Ctrl-C: the work ends with what it has.
    pub interrupt: Arc<AtomicBool>,
    /// Threads of parallel work; as many as processors where None.
    pub threads: Option<usize>,
}

impl Supervisor {
    /// Does the work on a thread of its own; gives what it gives.
    ///
    /// # Errors
    /// Those of the work, its panic, and what the callback raises (which ends the work).
    pub fn run<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&(dyn Fn(&str) + Sync)) -> Result<T, Failure> + Send,
    ) -> PyResult<T> {
        let (say, hear) = channel::<String>();
        // One thread listens, with the GIL free.
        let hear = Mutex::new(hear);
        // A word that nobody hears any more is no fault.
        let tell = move |words: &str| drop(say.send(words.to_owned()));
        let threads = self.threads;
        let mut raised = None;
        let done = thread::scope(|scope| {
            let job = move || guarded(move || within(threads, move || work(&tell)));
            let worker = thread::Builder::new().stack_size(STACK);
            let worker = worker.spawn_scoped(scope, job)?;
            loop {
                let heard = py.detach(|| match hear.lock() {
                    Ok(hear) => hear.recv_timeout(LOOK),
                    Err(_) => Err(RecvTimeoutError::Disconnected),
                });
                let told = match heard {
                    Ok(words) => self.tell(py, &words),
                    Err(RecvTimeoutError::Timeout) => Ok(()),
                    Err(RecvTimeoutError::Disconnected) => break,
                };
                if let Err(error) = told {
                    self.interrupt.store(true, Ordering::Relaxed);
                    raised.get_or_insert(error);
                }
                if py.check_signals().is_err() {
                    self.interrupt.store(true, Ordering::Relaxed);
                }
            }
            let done = py.detach(|| worker.join());
            Ok::<_, PyErr>(done)
        })?;
        if let Some(error) = raised {
            return Err(error);
        }
        match done {
            Ok(Ok(result)) => result.map_err(|failure| failure.raise(py)),
            Ok(Err(defect)) => Err(Failure::from(defect).raise(py)),
            Err(_) => Err(pyo3::exceptions::PyRuntimeError::new_err(
                "the work ended without a result",
            )),
        }
    }

    fn tell(&self, py: Python<'_>, words: &str) -> PyResult<()> {
        match &self.progress {
            Some(callback) => callback.call1(py, (words,)).map(drop),
            None => Ok(()),
        }
    }
}

/// Runs work within so many threads; the result does not depend on how many there are.
fn within<T: Send>(threads: Option<usize>, work: impl FnOnce() -> T + Send) -> T {
    let Some(threads) = threads else {
        return work();
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .stack_size(STACK)
        .build();
    match pool {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}

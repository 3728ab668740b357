//! Errors as exceptions of Python.

use std::path::Path;

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use tegula_io::deck::Diagnostic;
use tegula_io::job::JobError;

pyo3::import_exception!(tegula._errors, AnalysisError);
pyo3::import_exception!(tegula._errors, ModelError);
pyo3::import_exception!(tegula._errors, OutputError);

/// `ModelError` of the mistakes in a model.
pub fn of_model(found: Vec<Diagnostic>) -> PyErr {
    let rows: Vec<_> = found
        .into_iter()
        .map(|d| (d.file.display().to_string(), d.line, d.column, d.key, d.message, d.help))
        .collect();
    ModelError::new_err((rows,))
}

/// `AnalysisError` of an analysis, with the folder of the results up to the last finished step.
pub fn of_analysis(error: &tegula::Error, folder: Option<&Path>) -> PyErr {
    AnalysisError::new_err((error.to_string(), folder.map(|folder| folder.display().to_string())))
}

/// Advice for the command line as that for Python.
fn in_python(message: &str) -> String {
    [("`--out`", "`out`"), ("`--force`", "`force=True`"), ("`--resume`", "`resume=True`")]
        .iter()
        .fold(message.to_owned(), |text, (option, argument)| text.replace(option, argument))
}

/// Exception of a file.
pub fn of_output(error: tegula_io::out::OutputError) -> PyErr {
    OutputError::new_err(in_python(&error.to_string()))
}

/// Exception of a run.
pub fn of_run(error: JobError) -> PyErr {
    match error {
        JobError::Model(found) => of_model(found),
        JobError::Analysis { error, folder } => of_analysis(&error, Some(&folder)),
        JobError::Interrupted { folder, resumable } => {
            let how = if resumable { "; run(..., resume=True) continues the run" } else { "" };
            PyKeyboardInterrupt::new_err(format!(
                "interrupted: the results up to the last finished step are in {}{how}",
                folder.display()
            ))
        }
        other => OutputError::new_err(in_python(&other.to_string())),
    }
}

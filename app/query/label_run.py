"""Naming the instances of a finished run by a vocabulary, for `razer label` and `razer run --vocabulary`."""

from __future__ import annotations

from pathlib import Path

from app.console.streams import print_notes
from app.query.labelled_run import LabelledRun
from app.query.queryable_map import open_queryable_map
from app.run_folder.folder_lock import FolderLock
from razer.errors import BadInput
from razer.models import embedder_of
from razer.plugins import NO_TRUST, EmbedderSettings, Trust
from razer.query.text_queries import TextQueryEncoder
from razer.semantics.labelling import known_categories, label
from razer.vocabulary import Vocabulary


def label_run(
    folder: Path,
    vocabulary: Vocabulary,
    embedder: str | None = None,
    assignments: tuple[str, ...] = (),
    *,
    trust: Trust = NO_TRUST,
) -> LabelledRun:
    """Give each instance of a run the class that fits it best, and write what follows from it into its folder.

    Args:
        folder: of a finished run.
        vocabulary: the classes.
        embedder: a name or module:Class; None: the one that the run was made with.
        assignments: texts section.key=value that change the run's settings.
        trust: which outside code may be loaded besides what the command line names.

    Raises:
        BadInput: naming what is missing or damaged, while another process writes the folder, or where the embedder
            knows no name of the vocabulary.
    """
    with FolderLock(folder):
        return _label_run(folder, vocabulary, embedder, assignments, trust)


def _label_run(
    folder: Path, vocabulary: Vocabulary, embedder: str | None, assignments: tuple[str, ...], trust: Trust
) -> LabelledRun:
    queryable = open_queryable_map(folder, embedder, assignments, by_text=True, trust=trust)
    known = known_categories(queryable.panoptic, vocabulary)
    if n_unknown := len(vocabulary.categories) - len(known):
        print_notes([f"the embedder does not know {n_unknown} of the {len(vocabulary.categories)} names: left out"])
    labelled = LabelledRun.of(queryable, vocabulary.name, label(queryable.panoptic, known))
    try:
        labelled.write()
    except OSError as error:
        raise BadInput(f"{folder} cannot be written to ({error.strerror}): its older files are as they were") from error
    return labelled


def require_names(settings: EmbedderSettings, vocabulary: Vocabulary) -> None:
    """Raise BadInput where an embedder knows no name of a vocabulary, before anything is mapped with it."""
    encoder = TextQueryEncoder(embedder_of(settings))
    if not any(encoder.knows(name) for name in vocabulary.names):
        raise BadInput(f"the embedder knows no name of the vocabulary {vocabulary.name}: choose another of either")

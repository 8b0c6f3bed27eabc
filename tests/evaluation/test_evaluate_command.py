"""`halo evaluate`: what it is asked for, and what it answers to what it does not know."""

from __future__ import annotations

from pathlib import Path

import pytest

from halo_service.app.cli import main


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--method", "ours,theirs"], "no method 'theirs'; known: ours"),
        (["--materials", "stone"], "no material 'stone'; known: paper, wood"),
        (["--quick", "--tasks", "juggling"], "no task 'juggling'; known: hover, pointing-20"),
        (["--labels", "nowhere"], "there is no label file (*.txt) in nowhere"),
        (["--kept-only"], "no kept takes of these users and materials"),
        (["take.mkv"], "needs its truth: --truth"),
        (["take.mkv", "--truth", "t.jsonl"], "name the profile that goes with the recording"),
        (["take.mkv", "--truth", "t.jsonl", "--profile", "./none"], "there is no profile at none"),
    ],
)
def test_what_nobody_knows_is_answered_with_one_sentence(
    arguments: list[str],
    says: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    if "take.mkv" not in arguments:
        arguments = [*arguments, "--keep", "takes"]
    assert main(["evaluate", *arguments]) == 2
    told = capsys.readouterr()
    assert says in told.err
    assert told.out == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("option", "text"), [("--users", "301,-2"), ("--users", "all"), ("--jobs", "0")]
)
def test_numbers_that_are_none_are_refused(
    option: str, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["evaluate", option, text])
    assert f"argument {option}: {text!r} must be" in capsys.readouterr().err

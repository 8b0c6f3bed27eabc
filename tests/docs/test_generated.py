"""The generated pages and drawings are what their commands write, and links in the pages work."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from docs import drawings, latency, reference
from halo_service.evaluation.study.plan import REPORTED, TUNED
from halo_service.virtual.sim_url import OPTIONS

REPOSITORY = Path(__file__).parents[2]
FOLDER = REPOSITORY / "docs"
PAGES = sorted(
    path
    for pattern in (
        "*.md",
        "docs/*.md",
        "clients/*.md",
        "clients/*/*.md",
        "protocol/*.md",
        "calibration/*/*.md",
    )
    for path in REPOSITORY.glob(pattern)
)
GUIDES = [REPOSITORY / "README.md", *FOLDER.glob("*.md"), REPOSITORY / "clients" / "README.md"]


@pytest.mark.parametrize("name", reference.PAGES)
def test_a_reference_page_is_up_to_date(name: str) -> None:
    committed = (FOLDER / name).read_text(encoding="utf-8")
    assert committed == reference.PAGES[name](), "run `uv run python docs/reference.py`"


@pytest.mark.parametrize("name", ["pipeline.svg", "frames.svg"])
def test_a_drawing_is_up_to_date(name: str, tmp_path: Path) -> None:
    drawings.main(tmp_path)
    committed = (FOLDER / "pictures" / name).read_text(encoding="utf-8")
    assert committed == (tmp_path / name).read_text(encoding="utf-8"), (
        "run `uv run python docs/drawings.py`"
    )


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(REPOSITORY)))
def test_links_lead_to_files_and_headings(page: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if "://" in target:
            continue
        name, _, anchor = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        assert file.exists(), f"{target} is missing"
        if anchor:
            headings = re.findall(r"^#+ (.*)$", file.read_text(encoding="utf-8"), re.MULTILINE)
            assert anchor in map(_anchor, headings), f"no heading for {target}"


def _anchor(heading: str) -> str:
    """Return the anchor that code hosts give a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def test_a_new_latency_run_replaces_the_old_one() -> None:
    page = latency.PAGE.read_text(encoding="utf-8")
    once = latency.replaced(page, latency.measured("median 1.0\n", "abc1234"))
    twice = latency.replaced(once, latency.measured("median 2.0\n", "abc1234"))
    assert "median 1.0" in once and "median 1.0" not in twice
    assert "commit abc1234" in twice
    outside = [
        text.partition(latency.BEGIN)[0] + text.partition(latency.END)[2] for text in (page, twice)
    ]
    assert outside[0] == outside[1]


def test_ci_ends_with_the_test_command_of_the_readme() -> None:
    readme = (REPOSITORY / "README.md").read_text(encoding="utf-8")
    command = readme.partition("## Tests")[2].split("```")[1].strip()
    last = (REPOSITORY / ".ci" / "run").read_text(encoding="utf-8").strip().splitlines()[-1]
    assert last == f"HALO_CI=1 {command}"


@pytest.mark.parametrize("page", GUIDES, ids=lambda page: str(page.relative_to(REPOSITORY)))
def test_paths_in_backticks_exist(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    words = [word for span in re.findall(r"`([^`]+)`", text) for word in span.split()]
    folders = (REPOSITORY, REPOSITORY / "halo_service", page.parent)
    missing = [
        word
        for word in words
        if _is_path(word) and not any((folder / word).exists() for folder in folders)
    ]
    assert not missing, f"not in the repository: {missing}"


def _is_path(word: str) -> bool:
    """Whether it names a file or folder of ours. Places to fill in, such as NAME, are no paths."""
    if not re.fullmatch(r"\w[\w.-]*(/[\w.-]+)*/?", word) or "NAME" in word:
        return False
    top, slash, _ = word.partition("/")
    return bool(slash) and (word.endswith(("/", ".py")) or (REPOSITORY / top).is_dir())


@pytest.mark.parametrize(("name", "seeds"), [("tuning", TUNED), ("reported", REPORTED)])
def test_the_page_of_the_evaluation_names_the_users_of_the_plan(
    name: str, seeds: tuple[int, ...]
) -> None:
    page = (FOLDER / "evaluation.md").read_text(encoding="utf-8")
    (cell,) = re.findall(rf"^\| {name} \| ([\d, to]+) \|", page, re.MULTILINE)
    ranges = (part.split(" to ") for part in cell.split(", "))
    assert [seed for r in ranges for seed in range(int(r[0]), int(r[-1]) + 1)] == sorted(seeds)


def test_the_guide_lists_every_option_of_the_virtual_camera() -> None:
    page = (FOLDER / "virtual-kinect.md").read_text(encoding="utf-8")
    table = page.partition("| option | values |")[2].partition("\n\n")[0]
    listed = [
        option
        for row in table.splitlines()[2:]
        for option in re.findall(r"`(\w+)`", row.split(" | ")[0])
    ]
    assert sorted(listed) == sorted(["seed", *OPTIONS])

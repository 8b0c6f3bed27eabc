"""Files of the clients are complete or not there."""

import os

import pytest

from halo_client.files import appearing


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "it.csv"
    path.write_bytes(b"old")
    with pytest.raises(ValueError, match="broken"), appearing(path) as file:
        file.write(b"new")
        assert path.read_bytes() == b"old"
        raise ValueError("broken")
    assert path.read_bytes() == b"old"
    with appearing(path) as file:
        file.write(b"new")
    assert path.read_bytes() == b"new"
    assert [each.name for each in tmp_path.iterdir()] == ["it.csv"]


def test_an_error_names_the_file_that_was_asked_for(tmp_path):
    path = tmp_path / "missing" / "it.csv"
    with pytest.raises(OSError, match="No such file") as error, appearing(path):
        pass
    assert error.value.filename == str(path)
    with pytest.raises(IsADirectoryError), appearing(tmp_path):
        pass


def test_a_pipe_is_written_to_and_a_link_is_followed(tmp_path):
    with appearing(type(tmp_path)(os.devnull)) as file:
        file.write(b"x")
    link, target = tmp_path / "link", tmp_path / "target"
    link.symlink_to(target)
    with appearing(link) as file:
        file.write(b"x")
    assert link.is_symlink() and target.read_bytes() == b"x"

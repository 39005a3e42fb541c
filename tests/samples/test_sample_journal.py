from pathlib import Path

import pytest

from railsearch.errors import StorageError
from railsearch.samples.journal import Journal


@pytest.mark.parametrize("cut", range(1, 30))
def test_a_line_that_was_cut_off_is_dropped_and_the_others_stay_for_good(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "journal"
    journal = Journal(path)
    with journal.claimed():
        journal.begin({"number": 2})
        journal.append({"place": 1, "value": float("nan")})
        journal.append({"place": 2, "value": 0.1 + 0.2})
    path.write_bytes(path.read_bytes()[:-cut])
    with journal.claimed():
        assert [entry["place"] for entry in journal.entries] == [1]
        journal.append({"place": 3})
    journal.read()
    assert [entry["place"] for entry in journal.entries] == [1, 3]
    assert journal.head == {"number": 2}


def test_the_last_head_holds_and_an_empty_journal_leaves_nothing(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "journal")
    with journal.claimed():
        assert journal.head is None
    assert not journal.path.exists()
    with journal.claimed():
        journal.begin({"number": 2})
        journal.append({"place": 1})
        journal.begin({"number": 5})
    journal.read()
    assert journal.head == {"number": 5}
    assert journal.entries == [{"place": 1}]


def test_an_entry_is_in_the_file_before_anything_else_happens(tmp_path: Path) -> None:
    journal, other = Journal(tmp_path / "journal"), Journal(tmp_path / "journal")
    with journal.claimed():
        journal.begin({})
        for place in range(5):
            journal.append({"place": place})
            other.read()
            assert other.entries[-1] == {"place": place}


def test_a_journal_has_one_writer(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    with Journal(path).claimed(), pytest.raises(StorageError, match="in use by another process"), Journal(path).claimed():
        pass


def test_a_damaged_journal_is_not_continued(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    path.write_bytes(b'{"head": {}}\n\x00\x00\n{"place": 1}\n')
    with pytest.raises(StorageError, match="cannot be read"), Journal(path).claimed():
        pass
    assert path.read_bytes().endswith(b'{"place": 1}\n'), "nothing is lost"

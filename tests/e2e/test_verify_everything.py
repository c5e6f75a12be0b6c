# SPDX-License-Identifier: MIT
"""`drehgeber verify --write`: our own encoders agree with every clause that needs a write or a supply that is cut, and
afterwards they are as they were."""
import pytest

from verified import MODELS, WRITTEN, Crowd, cut, results, state, strange_lines, those, verify


@pytest.fixture(scope="module")
def crowd():
    crowd = Crowd()
    yield crowd
    assert strange_lines(crowd.end()) == []


@pytest.fixture(scope="module", autouse=True)
def written(crowd):
    """Every clause with writes and cut supplies is asked at once; model: [(results, same, folder)]."""
    def ask(model, folder, words):
        before, journal = state(model, folder), folder / "journal"
        ended = verify(model, folder / "link", "--json", "--write", "--power", folder / "relay", "--journal", journal, *words)
        assert "writes, and puts back" in ended.stderr and str(journal) in ended.stderr
        assert journal.read_bytes() == b""
        return results(ended), state(model, folder) == before, folder

    return {model: [crowd.pool.submit(ask, model, crowd.begin(f"write.{model}.{part}", model), words)
                    for part, words in enumerate(cut(model))] for model in MODELS}


@pytest.mark.parametrize("model", MODELS)
def test_everything_that_is_written_is_put_back(written, model):
    agrees, switched = set(), []
    for found, same, folder in (one.result() for one in written[model]):
        assert {clause: found[clause] for clause in those(found, "differs")} == {}
        assert same, folder
        agrees |= those(found, "agrees")
        switched += (folder / "switched").read_text().split() if (folder / "switched").exists() else []
    assert len(agrees) >= WRITTEN[model][1]
    assert switched and switched == ["off", "on"] * (len(switched) // 2)

"""Puts a release on the Hugging Face Hub: verified first, in one commit, so nobody sees half."""

from __future__ import annotations

import contextlib
import dataclasses
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from affectsim_data.releases.manifest import MANIFEST_NAME, Manifest
from affectsim_data.releases.stores import FolderStore
from affectsim_data.releases.transfers import Progress, failure_list, transfer
from affectsim_data.schemas import TableName

if TYPE_CHECKING:
    from huggingface_hub import HfApi

__all__ = ["Published", "check_publishable", "publish", "repository_id"]

_REPOSITORY = re.compile(r"(?:hf://datasets/)?([\w.-]+/[\w.-]+)/?")


@dataclasses.dataclass(frozen=True)
class Published:
    """What was put on the Hub."""

    uri: str
    """Address with the commit."""
    commit: str
    num_files: int
    """Files of the release; those that were there already were not sent again."""
    num_deleted: int
    """Files of an older version that are gone with this commit."""


def repository_id(text: str) -> str:
    """`ORG/NAME` from itself or from `hf://datasets/ORG/NAME`.

    Raises:
        ValueError: It is neither.
    """
    match = _REPOSITORY.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r}: expected ORG/NAME, a dataset on the Hub; a tag goes to --tag")
    return match[1]


def check_publishable(store: FolderStore, *, private: bool) -> None:
    """Raises unless a release is whole and may be passed on.

    Raises:
        ValueError: It is a partial copy, or holds what may not be passed on and `private` is not
            set.
    """
    manifest = store.manifest
    if manifest.partial_of is not None:
        raise ValueError(
            f"{store.uri}: this copy holds only {manifest.partial_of.describe()} of "
            f"{manifest.partial_of.uri}; upload the whole release"
        )
    if not private and (reasons := _why_not_public(manifest)):
        raise ValueError(
            f"{store.uri}: holds what may not be passed on: {'; '.join(reasons)}. Share its "
            f"recipe, {manifest.recipe!r}, so that others build the release from their own copies, "
            "or add --private to keep it to yourself"
        )


def _why_not_public(manifest: Manifest) -> list[str]:
    """Each source that may not be passed on, with its licence and where others get it."""
    reasons = [
        f"the {source.kind} of {source.name!r}, licence {source.licence or 'not stated'}"
        + (f" (to get it: {source.obtain.rstrip('.')})" if source.obtain else "")
        for source in manifest.sources
        if not source.redistribution
    ]
    if reasons or manifest.redistribution:
        return reasons
    return [f"its recipe says so of all of it, licences {', '.join(manifest.licences)}"]


def publish(
    store: FolderStore,
    repo_id: str,
    *,
    pages: Callable[[], Mapping[str, bytes]],
    private: bool = False,
    tag: str | None = None,
    message: str | None = None,
    jobs: int = 8,
) -> Published:
    """Uploads a release as one commit; the dataset is made if there is none.

    Args:
        store: The release.
        repo_id: `ORG/NAME`.
        pages: Gives what goes with it and is not in its manifest, by name: README.md above all.
            Asked once the release is verified.
        private: Whether only its owner may see the dataset.
        tag: Name for this version, which must be new.
        message: Of the commit.
        jobs: Files read or sent at a time.

    Raises:
        ValueError: The release is partial, broken or may not be passed on, the dataset is public
            and `private` is set, or the tag is taken.
        PermissionError: There is no token, or it may not write there.
        ConnectionError: The Hub cannot be reached or refuses; nothing was changed there.
    """
    check_publishable(store, private=private)
    place = f"hf://datasets/{repo_id}"
    api = _api(place)
    _verify(store, jobs=jobs)
    manifest, beside = store.manifest, pages()
    with _plain_errors(place):
        head = _open_repository(api, repo_id, private=private, tag=tag)
        remote = api.list_repo_files(repo_id, repo_type="dataset", revision=head)
        old = _outdated(remote, set(manifest.files))
        info = api.create_commit(
            repo_id,
            _operations(store, beside, old),
            commit_message=message
            or f"Release {manifest.name}, built by affectsim-data {manifest.code_version}",
            repo_type="dataset",
            num_threads=jobs,
            parent_commit=head,
        )
    uri = f"{place}@{info.oid}"
    if tag is not None:
        with _plain_errors(f"{uri} is uploaded, but not tagged {tag!r}; run the same again"):
            api.create_tag(repo_id, tag=tag, revision=info.oid, repo_type="dataset")
    return Published(uri, info.oid, len(manifest.files), len(old))


def _api(place: str) -> HfApi:
    from huggingface_hub import HfApi, get_token

    if get_token() is None:
        raise PermissionError(
            f"{place}: uploading needs a token of the Hugging Face Hub; run `hf auth login`, or "
            "set HF_TOKEN"
        )
    return HfApi()


def _verify(store: FolderStore, *, jobs: int) -> None:
    """Reads every file and compares it with the manifest."""

    def work(name: str, progress: Progress) -> None:
        progress(len(store.read(name)))

    sizes = {name: entry.bytes for name, entry in store.manifest.files.items()}
    failures = transfer(sizes, work, jobs=jobs, label=f"{store.manifest.name}: verifying")
    if failures:
        raise ValueError(
            f"{store.uri}: {len(failures)} of {len(sizes)} files are not what the manifest says; "
            f"nothing was uploaded:{failure_list(failures)}"
        )


def _open_repository(api: HfApi, repo_id: str, *, private: bool, tag: str | None) -> str:
    """Makes the dataset unless there is one; its newest commit."""
    # None leaves it to the organization: some have datasets private unless asked otherwise.
    api.create_repo(repo_id, repo_type="dataset", private=private or None, exist_ok=True)
    info = api.dataset_info(repo_id)
    if private and not info.private:
        # The Hub ignores the wish for a dataset that exists.
        raise ValueError(
            f"hf://datasets/{repo_id}: exists and is public; make it private in its settings on "
            "the Hub first, or choose another name"
        )
    for ref in api.list_repo_refs(repo_id, repo_type="dataset").tags if tag else ():
        if ref.name == tag:
            raise ValueError(
                f"hf://datasets/{repo_id}: the tag {tag!r} is taken, by {ref.target_commit}; a tag "
                "names one version for good, choose another"
            )
    assert info.sha is not None
    return info.sha


def _outdated(remote: list[str], names: set[str]) -> list[str]:
    """Files in the folders of a release that an older version left there."""
    tables = get_args(TableName)
    ours = [name for name in remote if "/" in name and name.split("/")[0] in tables]
    return sorted(set(ours) - names)


def _operations(store: FolderStore, beside: Mapping[str, bytes], old: list[str]) -> list[Any]:
    """All changes of the commit.

    Not `upload_folder`: from huggingface_hub 2 on it makes many commits of a large folder, and
    between two of them readers would find half a release.
    """
    from huggingface_hub import CommitOperationAdd, CommitOperationDelete

    adds = [
        CommitOperationAdd(path_in_repo=name, path_or_fileobj=Path(store.root, name))
        for name in [*store.manifest.files, MANIFEST_NAME]
    ]
    adds += [
        CommitOperationAdd(path_in_repo=name, path_or_fileobj=payload)
        for name, payload in beside.items()
    ]
    return [*(CommitOperationDelete(path_in_repo=name) for name in old), *adds]


@contextlib.contextmanager
def _plain_errors(place: str) -> Iterator[None]:
    """Turns what the Hub's client raises into errors a user can act on."""
    from huggingface_hub.errors import HfHubHTTPError, OfflineModeIsEnabled

    try:
        yield
    except ValueError:
        raise
    except OfflineModeIsEnabled as error:
        raise ConnectionError(f"{place}: HF_HUB_OFFLINE is set; unset it to upload") from error
    except HfHubHTTPError as error:
        status = error.response.status_code
        if status in (401, 403):
            raise PermissionError(
                f"{place}: the Hub refused the token (status {status}); run `hf auth login` with "
                "one that may write there"
            ) from error
        if status == 412:
            raise ConnectionError(
                f"{place}: somebody else changed the dataset meanwhile; nothing was uploaded, run "
                "the same again"
            ) from error
        raise ConnectionError(f"{place}: {error}") from error
    except Exception as error:  # what the client's transport raises differs by its version
        cause = f" ({error.__cause__})" if error.__cause__ else ""
        raise ConnectionError(f"{place}: {error}{cause}") from error

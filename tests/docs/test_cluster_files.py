"""The files for clusters in docs/examples: what `ray up` takes, and the fields that KubeRay requires."""

from __future__ import annotations

import json
import re
from importlib.util import find_spec
from pathlib import Path

import jsonschema
import pytest
import yaml

from app.cli import app
from tests.support.page_commands import calls

EXAMPLES = Path(__file__).resolve().parents[2] / "docs" / "examples"
# Ours, after KubeRay's documentation: a field that is misspelt is refused, as its own schema would drop it in silence.
POD = {"type": "object", "required": ["spec"], "properties": {"spec": {"required": ["containers"]}}}
GROUP = {"rayStartParams": {"type": "object", "additionalProperties": {"type": "string"}}, "template": POD}
NUMBERS = {name: {"type": "integer", "minimum": 0} for name in ("replicas", "minReplicas", "maxReplicas")}
CLUSTER = {
    "type": "object",
    "required": ["headGroupSpec"],
    "additionalProperties": False,
    "properties": {
        "rayVersion": {"type": "string"},
        "enableInTreeAutoscaling": {"type": "boolean"},
        "headGroupSpec": {"required": ["template"], "additionalProperties": False, "properties": GROUP},
        "workerGroupSpecs": {
            "type": "array",
            "items": {
                "required": ["groupName", "maxReplicas", "minReplicas", "template"],
                "additionalProperties": False,
                "properties": {**GROUP, **NUMBERS, "groupName": {"type": "string"}},
            },
        },
    },
}
JOB = {
    "type": "object",
    "additionalProperties": False,
    "required": ["rayClusterSpec"],
    "properties": {
        "entrypoint": {"type": "string"},
        "shutdownAfterJobFinishes": {"type": "boolean"},
        "backoffLimit": {"type": "integer"},
        "rayClusterSpec": CLUSTER,
    },
}


def content_of(name: str) -> dict:
    return yaml.safe_load((EXAMPLES / name).read_text(encoding="utf-8"))


def test_what_ray_up_takes_fits_its_schema():
    spec = find_spec("ray")
    if spec is None or spec.origin is None:
        pytest.skip("the extra cluster is not installed")
    schema = json.loads((Path(spec.origin).parent / "autoscaler" / "ray-schema.json").read_text())
    cluster = content_of("ray_cluster.yaml")
    jsonschema.validate(cluster, schema)
    assert cluster["head_node_type"] in cluster["available_node_types"]
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(cluster | {"max_worker": 8}, schema)


def test_what_kuberay_takes_has_its_fields():
    job = content_of("kuberay_job.yaml")
    assert (job["apiVersion"], job["kind"]) == ("ray.io/v1", "RayJob")
    jsonschema.validate(job["spec"], JOB)
    groups = [job["spec"]["rayClusterSpec"]["headGroupSpec"], *job["spec"]["rayClusterSpec"]["workerGroupSpecs"]]
    for group in groups:
        pod = group["template"]["spec"]
        mounted = {mount["name"] for one in pod["containers"] for mount in one.get("volumeMounts", ())}
        assert mounted == {volume["name"] for volume in pod.get("volumes", ())}


def test_the_job_is_a_command_that_is_understood():
    (arguments,) = calls(content_of("kuberay_job.yaml")["spec"]["entrypoint"])
    app.parse_args(arguments, exit_on_error=False, print_error=False)


def test_no_key_is_in_the_files():
    for path in EXAMPLES.glob("*.yaml"):
        assert not re.search(r"AKIA|aws_secret|password", path.read_text(encoding="utf-8"), re.I)

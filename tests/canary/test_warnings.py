"""Each warning of the project stops the build, on this machine and for the target."""
import pytest

WARNINGS = {"conversion": "conversion", "double_promotion": "double-promotion", "shadow": "shadow",
            "strict_prototypes": "strict-prototypes", "vla": "vla"}


@pytest.mark.parametrize("preset", ["sanitizers", "cortex_m4"])
@pytest.mark.parametrize("defect", WARNINGS)
def test_build_rejects(request, preset, defect):
    result = request.getfixturevalue(preset)(f"canary_warning_{defect}")
    assert result.returncode != 0
    assert f"[-Werror={WARNINGS[defect]}]" in result.stdout, result.stdout


@pytest.mark.parametrize("preset", ["sanitizers", "cortex_m4"])
def test_build_accepts(request, preset):
    result = request.getfixturevalue(preset)("canary_warning_clean")
    assert result.returncode == 0, result.stdout

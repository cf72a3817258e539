"""Habitat scene datasets in: `read_dataset(config)`, then `import_scene(dataset, handle)`."""

from affectsim_data.builders.habitat.dataset import Dataset, read_dataset
from affectsim_data.builders.habitat.scene import import_scene

__all__ = ["Dataset", "import_scene", "read_dataset"]

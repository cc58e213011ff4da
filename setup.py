"""ament_python package; also installs with plain pip, without ROS."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "flex_ident"

setup(
    name=NAME,
    version="0.1.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", "report/*.html", "nodes/*.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/config", [str(p) for p in sorted(Path("config").glob("*.yaml"))]),
        (f"share/{NAME}/launch", [str(p) for p in sorted(Path("launch").glob("*.launch.py"))]),
    ],
    python_requires=">=3.11",
    install_requires=[
        "numpy>=1.26",
        "scipy>=1.11",
        "rosbags>=0.10",
        "pyyaml",
        "matplotlib",
        "jinja2",
        "tqdm",
        "numba",
    ],
    extras_require={
        "foxglove": ["protobuf"],
        "hdf5": ["h5py"],
        "parquet": ["pyarrow"],
        "formats": ["protobuf", "h5py", "pyarrow"],
        "fleet": ["dask", "distributed", "pyarrow"],
        "test": [
            "pytest",
            "pytest-xdist",
            "pytest-rerunfailures",
            "mujoco",
            "mcap",
            "protobuf",
            "h5py",
            "pyarrow",
            "dask",
            "distributed",
        ],
        "bench": ["mujoco[sysid]", "pysindy"],
    },
    zip_safe=True,
    maintainer="flex_ident maintainers",
    maintainer_email="flex-ident@example.org",
    description="Identifies flexible robot joints from one recorded chirp and names what the model lacks.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "chirp_exciter = flex_ident.nodes.starting:chirp_exciter",
            "identifier = flex_ident.nodes.starting:identifier",
            "simulated_joint = flex_ident.nodes.starting:simulated_joint",
            "identify_bag = flex_ident.commands.identify_bag:main",
            "explain_gap = flex_ident.commands.explain_gap:main",
            "flex_ident = flex_ident.commands.flex_ident:main",
        ],
    },
)

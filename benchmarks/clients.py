"""Other programs read a case: the table of ``docs/how-to/other-programs.md``, checked.

    .ci/with-slurm python -m benchmarks.clients --environments FOLDER [--write]

Each program tells the deepest wear at the last snapshot, which must be that of the file; a plug-in
of Snakemake runs the case. A program in Python has an environment of its own in the folder, made if
it is not there; the others, Debian's, are skipped if they are not on the path. Exit status 1 if a
program fails.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import yaml

from fretwear.data.export import WRITERS
from fretwear.data.files import write_case
from fretwear.data.merge import merge_study
from fretwear.run.simulate import run
from fretwear.run.workflow import SNAKEFILE, workspace
from fretwear.study.reading import load_study

PAGE = Path(__file__).parents[1] / "docs/how-to/other-programs.md"
BEGIN, END = "<!-- programs -->\n", "<!-- end of programs -->\n"
STUDY = {
    "base": {
        "youngs_modulus": "208 GPa", "poisson_ratio": 0.3, "wear_coefficient": "7e-13 / Pa",
        "radius": "10 mm", "load": "50 N", "tangential_ratio": 0.8, "friction": 0.5,
        "plastic_limit": "none", "roughness": "none", "cell": ["8 um", "10 um"], "cycles": 100,
    },
    "output": {"cycles": [0, 100]},
}  # fmt: skip


class Program(NamedTuple):
    """A program, how it finds the depth, and what a user has to know."""

    name: str
    needs: str  # requirements of pip, the program first; or the command that must be on the path
    depth: str  # Python that assigns `depth`, or a command of the shell that prints it
    reads: str
    advice: str = "–"
    version: str = ""  # command that prints the version among words; empty for Python


CASE, MESH, MAP, STUDIES = "case files and summaries", "`--to vtk`", "`--to x3p`", "runs studies"
ZARR = "icechunk zarr dask h5netcdf obstore obspec-utils"
REVERSED = "dimensions are reversed: y, x, cycle"
# Both ask the network for the names of the conventions, at each variable again if there is none.
FIELD = """
import urllib.request, {library}
def refuse(*_, **__): raise OSError
urllib.request.urlopen = refuse
fields = {library}.read("case.nc")
depth = next(f for f in fields if f.nc_get_variable() == "wear_depth").array[-1].max()
"""
# References to the bytes of a file have to give every number of it.
REFERRED = """
from pathlib import Path
import xarray as xr
{}
for path in map(Path.resolve, (Path('summary.nc'), Path('case.nc'))):
    with xr.open_dataset(path, engine='h5netcdf') as file:
        found = xr.open_zarr({}, consolidated=False)
        xr.testing.assert_equal(found.load(), file.load())
depth = found.wear_depth[-1].values.max()
"""
# A plug-in, which runs the study in a folder of its own.
JOB = """
snakemake --snakefile $SNAKEFILE --config study=case --cores 2 --jobs 2 {} results/case/summary.nc >&2
python -c 'import xarray as x
print(float(x.open_dataset("results/case/summary.nc").maximum_wear_depth[-1]))'
"""
PLUGIN = """python -c 'from importlib.metadata import version; print(version("snakemake-{}"))'"""
PROGRAMS = (
    Program(
        "h5netcdf", "h5netcdf==1.8.2 h5py",
        "import h5netcdf; file = h5netcdf.File('case.nc'); depth = file['wear_depth'][-1].max()",
        CASE, 'also `xr.open_dataset(…, engine="h5netcdf")`, which needs no netCDF library',
    ),
    Program(
        "iris", "scitools-iris==3.14.1 xxhash<4",
        "import iris\ncubes = iris.load('case.nc')\n"
        "depth = next(c for c in cubes if c.var_name == 'wear_depth').data[-1].max()",
        CASE, "choose by `var_name`; with xxhash 4 iris does not load",
    ),
    Program(
        "cfdm", "cfdm==1.13.3.0", FIELD.format(library="cfdm"),
        CASE, "choose by `nc_get_variable()`",
    ),
    Program(
        "cf-python", "cf-python==3.21.0", FIELD.format(library="cf"),
        CASE, "likewise; needs the library UDUNITS-2",
    ),
    Program(
        "pint-xarray", "pint-xarray==0.6.1 cf-xarray netCDF4 xarray",
        "import cf_xarray.units, pint_xarray, xarray\n"
        "case = xarray.open_dataset('case.nc').pint.quantify()\n"
        "depth = case.wear_depth[-1].max().pint.to('um').item().magnitude * 1e-6",
        CASE, "import `cf_xarray.units` first, which knows `m3` and `Pa-1`",
    ),
    Program(
        "compliance-checker", "compliance-checker==6.1.0",
        "import subprocess, sys, netCDF4\nfrom pathlib import Path\n"
        "checker = Path(sys.executable).with_name('compliance-checker')\n"
        "subprocess.run([checker, '--test', 'cf:1.11', '--criteria', 'lenient', 'case.nc'],"
        " check=True, stdout=subprocess.DEVNULL)\n"
        "file = netCDF4.Dataset('case.nc'); depth = file['wear_depth'][-1].max()",
        "case files", "takes minutes",
    ),
    Program(
        "VirtualiZarr", f"virtualizarr==2.5.1 {ZARR}",
        REFERRED.format(
            "from obspec_utils.registry import ObjectStoreRegistry\nfrom obstore.store import LocalStore\n"
            "from virtualizarr.parsers import HDFParser",
            "HDFParser()(path.as_uri(), ObjectStoreRegistry({'file://': LocalStore()})), zarr_format=3",
        ),
        CASE, "see [a study in the cloud](#a-study-in-the-cloud)",
    ),
    Program(
        "kerchunk", f"kerchunk==0.2.10 {ZARR}",
        REFERRED.format(
            "from kerchunk.hdf import SingleHdf5ToZarr",
            "'reference://', zarr_format=2, storage_options={'fo': SingleHdf5ToZarr(str(path)).translate()}",
        ),
        CASE, "write references by `kerchunk.hdf`; those of VirtualiZarr's `to_kerchunk` lose single numbers",
    ),
    Program(
        "R, ncdf4", "Rscript",
        "Rscript -e 'library(ncdf4); d <- ncvar_get(nc_open(\"case.nc\"), \"wear_depth\");"
        " cat(max(d[, , dim(d)[3]]))'",
        CASE, REVERSED,
        "Rscript -e 'packageVersion(\"ncdf4\")'",
    ),
    Program(
        "Octave, netcdf", "octave",
        "octave --eval 'pkg load netcdf; d = ncread(\"case.nc\", \"wear_depth\");"
        " printf(\"%.9g\", max(max(d(:, :, end))))'",
        CASE, f"{REVERSED}; MATLAB has the same `ncread`",
        "octave --eval 'pkg load netcdf; disp(pkg(\"list\", \"netcdf\"){1}.version)'",
    ),
    Program(
        "ncdump", "ncdump",
        "ncdump -p 9 -v maximum_wear_depth case.nc | tr -d ' ;' | grep '^maximum_wear_depth=' | tr , '\\n' | tail -n 1 | cut -d= -f2",
        "everything, as text", "`ncdump -h` shows names and units",
        "ncdump",
    ),
    Program(
        "cdo", "cdo", "cdo -s outputf,%.9g,1 -fldmax -selname,wear_depth case.nc | tail -n 1",
        "fields of case files", "summaries: variables of two parameters or more are skipped",
        "cdo --version",
    ),
    Program(
        "nco", "ncks", "ncks -H -C -v maximum_wear_depth -d cycle,-1 -s '%.9g' case.nc",
        CASE, "joins cases of equal windows only: use `open_study`",
        "ncks --version",
    ),
    Program(
        "GDAL", "gdalmdimtranslate",
        "gdalmdimtranslate -q -array 'name=wear_depth,view=[-1,...]' case.nc depth.tif"
        " && gdal_translate -q -of XYZ depth.tif /vsistdout/ | sort -g -k 3 | tail -n 1 | cut -d ' ' -f 3",
        "a map at a snapshot, by the command below", "its raster reader, which QGIS uses, shows x downwards",
        "gdalinfo --version",
    ),
    Program(
        "vtk, ParaView's reader", "vtk==9.7.2",
        "import vtk\nfrom vtk.util.numpy_support import vtk_to_numpy\nreader = vtk.vtkNetCDFCFReader()\n"
        "reader.SetFileName('case.nc')\nreader.SphericalCoordinatesOff()\nreader.UpdateMetaData()\n"
        "reader.SetDimensions('(cycle, x, y)')\nreader.Update()\n"
        "found = reader.GetOutputDataObject(0).GetPointData().GetArray('wear_depth')\n"
        "depth = vtk_to_numpy(found).max()",
        "fields of case files", "see [ParaView and QGIS](#paraview-and-qgis)",
    ),
    Program(
        "meshio", "meshio==5.3.5",
        "import meshio; depth = meshio.read('case-0001.vtu').point_data['wear_depth'].max()",
        MESH, "opens one `.vtu`; it reads no `.pvd`",
    ),
    Program(
        "pyvista", "pyvista==0.49.1",
        "import pyvista\nreader = pyvista.get_reader('case.pvd')\n"
        "reader.set_active_time_point(reader.number_time_points - 1)\n"
        "depth = reader.read()[0]['wear_depth'].max()",
        MESH, "`pyvista.read` of the `.pvd` has the first snapshot only: use `get_reader`",
    ),
    Program(
        "SurfaceTopography", "SurfaceTopography==1.27.1",
        "import SurfaceTopography as s; depth = -s.read_topography('case.x3p').to_unit('m').heights().min()",
        MAP,
    ),
    Program(
        "surfalize", "surfalize==0.19.2",
        "import surfalize; depth = -1e-6 * surfalize.Surface.load('case.x3p').data.min()",
        MAP, "heights are in µm",
    ),
    Program(
        "x3pio", "x3pio==2.0.0",
        "import x3pio; depth = -x3pio.read('case.x3p').layers[0].z.min()",
        MAP,
    ),
    Program(
        "Snakemake, slurm", "sbatch",
        JOB.format("--profile $PROFILES/slurm"),
        STUDIES, "see [a cluster](cluster.md)", PLUGIN.format("executor-plugin-slurm"),
    ),
    Program(
        "Snakemake, cluster-generic", "snakemake-executor-plugin-cluster-generic==1.0.9 packaging<26",
        "echo 'sh $1 >&2 & echo $!' > submit" + JOB.format(
            "--executor cluster-generic --cluster-generic-submit-cmd 'sh submit' --latency-wait 60"
        ),
        STUDIES, "for any command that submits a script", PLUGIN.format("executor-plugin-cluster-generic"),
    ),
    Program(
        "Snakemake, storage fs", "snakemake-storage-plugin-fs==1.1.3 packaging<26",
        "if snakemake --snakefile $SNAKEFILE --config study=case --cores 2 --default-storage-provider fs >&2; then exit 1; fi"
        + JOB.format(""),
        "refused", "run in a folder that all machines share, and copy `results/`",
        PLUGIN.format("storage-plugin-fs"),
    ),
)  # fmt: skip


def environment(folder: Path, needs: str, *, is_plugin: bool) -> Path:
    """The folder of an environment with these requirements, which is made unless it is there."""
    place = folder.absolute() / re.sub(r"\W+", "-", needs.split()[0])
    if not (place / "done").exists():
        if is_plugin:
            command = [sys.executable, "-m", "pip", "install", "--target", place]
        else:
            subprocess.run([sys.executable, "-m", "venv", place], check=True)
            command = [place / "bin/pip", "install"]
        subprocess.run([*command, "--quiet", *needs.split()], check=True)
        (place / "done").touch()
    return place


def found(program: Program, environments: Path, folder: str) -> tuple[str, float]:
    """The version of a program, and the depth that it finds."""
    paths = {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    paths |= {"SNAKEFILE": SNAKEFILE, "PROFILES": str(workspace() / "profiles")}
    if not program.version:
        python = environment(environments, program.needs, is_plugin=False) / "bin/python"
        name = re.split("[=<> ]", program.needs)[0]
        shown = f"from importlib.metadata import version\nprint(version('{name}'))\n"
        script = f"{shown}{program.depth}\nprint(depth)"
        command = [str(python), "-W", "ignore", "-c", script]
    else:
        if "==" in program.needs:
            place = environment(environments, program.needs, is_plugin=True)
            paths["PYTHONPATH"] = str(place)
        number = f"({program.version}) 2>&1 | grep -oE '[0-9]+([.][0-9]+)+' | head -n 1"
        command = ["bash", "-c", f"{number}; set -eo pipefail; {program.depth}"]
    done = subprocess.run(
        command, cwd=folder, check=True, capture_output=True, text=True, env=os.environ | paths
    )
    version, *_, depth = done.stdout.split()
    return version, float(depth)


def main() -> int:
    """Run all programs; print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.clients")
    parser.add_argument("--environments", type=Path, required=True)
    parser.add_argument("--write", action="store_true", help="write the table into the page")
    options = parser.parse_args()
    table, failed = ["| program | reads | what to do |", "| --- | --- | --- |"], []
    with tempfile.TemporaryDirectory() as folder:
        study = Path(folder, "studies/case.yaml")
        study.parent.mkdir()
        study.write_text(yaml.safe_dump(STUDY), encoding="utf-8")
        points = load_study(study)
        ((case_id, case),) = points.cases().items()
        results = run(case)
        stored = Path(folder, f"cases/{case_id}.nc")
        write_case(results.dataset, results.history, stored)
        shutil.copy(stored, Path(folder, "case.nc"))
        merge_study(points, stored.parent, Path(folder, "summary.nc"))
        whole = results.dataset.fretwear.full()
        for ending, write in (WRITERS["vtk"], WRITERS["x3p"]):
            write(whole, Path(folder, f"case{ending}"))
        deepest = float(whole["wear_depth"][-1].max())
        for program in PROGRAMS:
            shutil.rmtree(Path(folder, "results"), ignore_errors=True)
            if program.version and "==" not in program.needs and not shutil.which(program.needs):
                print(f"{program.name}: {program.needs} is not here")
                continue
            try:
                version, depth = found(program, options.environments, folder)
            except (subprocess.CalledProcessError, ValueError) as error:
                failed.append(f"{program.name}: {error}: {getattr(error, 'stderr', '')}")
                print(failed[-1], flush=True)
                continue
            if abs(depth / deepest - 1.0) > 1e-4:
                failed.append(f"{program.name} reads {depth}, not {deepest}")
            table.append(f"| {program.name} {version} | {program.reads} | {program.advice} |")
            print(table[-1], flush=True)
    print(*failed, sep="\n")
    if options.write and not failed:
        text = PAGE.read_text(encoding="utf-8")
        start, end = text.index(BEGIN) + len(BEGIN), text.index(END)
        PAGE.write_text(text[:start] + "\n".join(table) + "\n" + text[end:], encoding="utf-8")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())

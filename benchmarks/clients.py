"""Other programs read a case: the table of ``docs/how-to/other-programs.md``, checked.

    python -m benchmarks.clients --environments FOLDER [--write]

Each program prints the deepest wear at the last snapshot, which must be that of the file. A program
in Python has an environment of its own in the folder, made if it is not there; the others, Debian's,
are skipped if they are not on the path. Exit status 1 if a program fails.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from fretwear import Case
from fretwear.data.export import WRITERS
from fretwear.data.files import write_case
from fretwear.run.simulate import run

PAGE = Path(__file__).parents[1] / "docs/how-to/other-programs.md"
BEGIN, END = "<!-- programs -->\n", "<!-- end of programs -->\n"


class Program(NamedTuple):
    """A program, how it prints the depth, and what a user has to know."""

    name: str
    needs: str  # requirements of pip, or the command that has to be on the path
    version: str  # prints the version
    script: str
    reads: str
    advice: str
    is_python: bool = True


def python(distribution: str) -> str:
    """What prints the version of a distribution."""
    return f"from importlib.metadata import version; print(version('{distribution}'))"


CASE, MESH, MAP = "case files and summaries", "`--to vtk`", "`--to x3p`"
PROGRAMS = (
    Program(
        "h5netcdf", "h5netcdf==1.8.2 h5py", python("h5netcdf"),
        "import h5netcdf; file = h5netcdf.File('case.nc'); print(file['wear_depth'][-1].max())",
        CASE, "also `xr.open_dataset(…, engine=\"h5netcdf\")`, which needs no netCDF library",
    ),
    Program(
        "iris", "scitools-iris==3.14.1 xxhash<4", python("scitools-iris"),
        "import iris\ncubes = iris.load('case.nc')\n"
        "print([c for c in cubes if c.var_name == 'wear_depth'][0].data[-1].max())",
        CASE, "choose by `var_name`; with xxhash 4 iris does not load",
    ),
    Program(
        "cfdm", "cfdm==1.13.3.0", python("cfdm"),
        "import cfdm\nfields = cfdm.read('case.nc')\n"
        "print([f for f in fields if f.nc_get_variable() == 'wear_depth'][0].array[-1].max())",
        CASE, "choose by `nc_get_variable()`",
    ),
    Program(
        "VirtualiZarr", "virtualizarr==2.5.1 icechunk zarr dask h5netcdf obstore obspec-utils kerchunk==0.2.10",
        python("virtualizarr"),
        "from pathlib import Path\nimport xarray as xr\nfrom obspec_utils.registry import ObjectStoreRegistry\n"
        "from obstore.store import LocalStore\nfrom virtualizarr.parsers import HDFParser\n"
        "store = HDFParser()(Path('case.nc').resolve().as_uri(), ObjectStoreRegistry({'file://': LocalStore()}))\n"
        "print(xr.open_zarr(store, consolidated=False, zarr_format=3).wear_depth[-1].values.max())",
        CASE, "see [a study in the cloud](#a-study-in-the-cloud)",
    ),
    Program(
        "kerchunk", "virtualizarr==2.5.1 icechunk zarr dask h5netcdf obstore obspec-utils kerchunk==0.2.10",
        python("kerchunk"),
        "import kerchunk.hdf, xarray as xr\n"
        "references = kerchunk.hdf.SingleHdf5ToZarr('case.nc').translate()\n"
        "print(xr.open_dataset(references, engine='kerchunk').wear_depth[-1].values.max())",
        "fields of case files", "parameters, single numbers, become NaN or 0: use VirtualiZarr's own parser",
    ),
    Program(
        "R, ncdf4", "Rscript", "Rscript -e 'cat(as.character(packageVersion(\"ncdf4\")))'",
        "Rscript -e 'library(ncdf4); d <- ncvar_get(nc_open(\"case.nc\"), \"wear_depth\");"
        " cat(max(d[, , dim(d)[3]]))'",
        CASE, "dimensions are reversed: y, x, cycle", is_python=False,
    ),
    Program(
        "Octave, netcdf", "octave", "octave --eval 'pkg load netcdf; disp(pkg(\"list\", \"netcdf\"){1}.version)'",
        "octave --eval 'pkg load netcdf; d = ncread(\"case.nc\", \"wear_depth\");"
        " printf(\"%.9g\", max(max(d(:, :, end))))'",
        CASE, "dimensions are reversed: y, x, cycle; MATLAB has the same `ncread`", is_python=False,
    ),
    Program(
        "ncdump", "ncdump", "ncdump 2>&1 | grep -o 'version [0-9.]*' | cut -d' ' -f2",
        "ncdump -p 9 -v maximum_wear_depth case.nc | tr -d ' ;' | grep '^maximum_wear_depth=' | tr , '\\n' | tail -n 1 | cut -d= -f2",
        "everything, as text", "`ncdump -h` shows names and units", is_python=False,
    ),
    Program(
        "cdo", "cdo", "cdo --version 2>&1 | grep -o '[0-9.]*[0-9]' | head -n 1",
        "cdo -s outputf,%.9g,1 -fldmax -selname,wear_depth case.nc",
        "fields of case files", "summaries: variables of two parameters or more are skipped", is_python=False,
    ),
    Program(
        "nco", "ncks", "ncks --version 2>&1 | grep -o 'version [0-9.]*' | head -n 1 | cut -d' ' -f2",
        "ncks -H -C -v maximum_wear_depth -d cycle,-1 -s '%.9g' case.nc",
        CASE, "joins cases of equal windows only; means count NaN outside the window: use `open_study`", is_python=False,
    ),
    Program(
        "GDAL", "gdalmdimtranslate", "gdalinfo --version | grep -o '[0-9][0-9.]*[0-9]' | head -n 1",
        "gdalmdimtranslate -q -array 'name=wear_depth,view=[-1,...]' case.nc depth.tif"
        " && gdal_translate -q -of XYZ depth.tif /vsistdout/ | sort -g -k 3 | tail -n 1 | cut -d ' ' -f 3",
        "a map at a snapshot, by the command below", "its raster reader, which QGIS uses, shows x downwards", is_python=False,
    ),
    Program(
        "meshio", "meshio==5.3.5", python("meshio"),
        "import meshio; print(meshio.read('case-0001.vtu').point_data['wear_depth'].max())",
        MESH, "opens one `.vtu`; it reads no `.pvd`",
    ),
    Program(
        "pyvista", "pyvista==0.49.1", python("pyvista"),
        "import pyvista\nreader = pyvista.get_reader('case.pvd')\n"
        "reader.set_active_time_point(reader.number_time_points - 1)\nprint(reader.read()[0]['wear_depth'].max())",
        MESH, "`pyvista.read` of the `.pvd` has the first snapshot only: use `get_reader`",
    ),
    Program(
        "SurfaceTopography", "SurfaceTopography==1.27.1", python("SurfaceTopography"),
        "import SurfaceTopography as s; print(-s.read_topography('case.x3p').to_unit('m').heights().min())",
        MAP, "",
    ),
    Program(
        "surfalize", "surfalize==0.19.2", python("surfalize"),
        "import surfalize; print(-1e-6 * surfalize.Surface.load('case.x3p').data.min())",
        MAP, "heights are in µm",
    ),
    Program(
        "x3pio", "x3pio==2.0.0", python("x3pio"),
        "import x3pio; print(-x3pio.read('case.x3p').layers[0].z.min())",
        MAP, "",
    ),
)  # fmt: skip


def environment(folder: Path, needs: str) -> Path:
    """The Python of an environment with these requirements, which is made unless it is there."""
    place = folder / re.sub(r"\W+", "-", needs.split()[0])
    if not (place / "done").exists():
        subprocess.run([sys.executable, "-m", "venv", place], check=True)
        subprocess.run([place / "bin/pip", "install", "--quiet", *needs.split()], check=True)
        (place / "done").touch()
    return (place / "bin/python").absolute()


def printed(program: Program, script: str, environments: Path, folder: str) -> str:
    """What a script prints."""
    if program.is_python:
        command = [str(environment(environments, program.needs)), "-W", "ignore", "-c", script]
    else:
        command = ["bash", "-c", script]
    done = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    return done.stdout.strip().splitlines()[-1]


def main() -> int:
    """Run all programs; print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.clients")
    parser.add_argument("--environments", type=Path, required=True)
    parser.add_argument("--write", action="store_true", help="write the table into the page")
    options = parser.parse_args()
    steel = {"youngs_modulus": "208 GPa", "poisson_ratio": 0.3, "wear_coefficient": "7e-13 / Pa"}
    contact = {"radius": "10 mm", "load": "50 N", "tangential_ratio": 0.8, "friction": 0.5}
    case = Case(**steel, **contact, cell=["8 um", "10 um"], cycles=100, output_cycles=[0, 100])
    table, failed = ["| program | reads | what to do |", "| --- | --- | --- |"], []
    with tempfile.TemporaryDirectory() as folder:
        results = run(case)
        write_case(results.dataset, results.history, Path(folder, "case.nc"))
        whole = results.dataset.fretwear.full()
        for ending, write in (WRITERS["vtk"], WRITERS["x3p"]):
            write(whole, Path(folder, f"case{ending}"))
        deepest = float(whole["wear_depth"][-1].max())
        for program in PROGRAMS:
            if not program.is_python and not shutil.which(program.needs):
                print(f"{program.name}: {program.needs} is not here")
                continue
            try:
                number = float(printed(program, program.script, options.environments, folder))
                version = printed(program, program.version, options.environments, folder)
            except (subprocess.CalledProcessError, ValueError, IndexError) as error:
                failed.append(f"{program.name}: {error}: {getattr(error, 'stderr', '')}")
                continue
            if abs(number / deepest - 1.0) > 1e-4:
                failed.append(f"{program.name} reads {number}, not {deepest}")
            table.append(
                f"| {program.name} {version} | {program.reads} | {program.advice or '–'} |"
            )
            print(table[-1], flush=True)
    print(*failed, sep="\n")
    if options.write and not failed:
        text = PAGE.read_text(encoding="utf-8")
        start, end = text.index(BEGIN) + len(BEGIN), text.index(END)
        PAGE.write_text(text[:start] + "\n".join(table) + "\n" + text[end:], encoding="utf-8")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())

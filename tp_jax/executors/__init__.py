"""Many independent pieces of work, in processes here or on other machines, all by one seam.

    choice                 which executor was asked for, and how many pieces it has in hand
    pieces                 the seam: hands pieces to an executor, gives results as they end
    calls                  what travels to a worker, and how it is carried out there
    processors             each worker computes on one processor, so that results are equal
    workers                an executor whose workers are replaced when they die
    local_processes        processes of this machine, the default
    ray_actors             Ray's actors, with the extra `ray`
    dask_workers           Dask's workers, with the extra `dask`
    slurm_jobs             jobs of a Slurm cluster, by submitit, with the extra `slurm`
    missing                what is said where the package of an extra is not installed

All of them are a `concurrent.futures.Executor`; whatever queues or places work is theirs.
"""

from tp_jax.executors.choice import KINDS as KINDS
from tp_jax.executors.choice import ExecutorChoice as ExecutorChoice
from tp_jax.executors.pieces import Ended as Ended
from tp_jax.executors.pieces import Piece as Piece
from tp_jax.executors.pieces import done_before as done_before
from tp_jax.executors.pieces import forget_pieces as forget_pieces
from tp_jax.executors.pieces import run_pieces as run_pieces
from tp_jax.executors.processors import available as available

#!/usr/bin/env bash
# A fleet as an array of Slurm, and the table when all of it is done:
#
#   sbatch --array=1-64 packaging/fleet/slurm.sh nights.parquet /shared/items
#   sbatch --dependency=afterany:JOB packaging/fleet/slurm.sh nights.parquet /shared/items
#
# Jobs may be killed, preempted and queued again: items that are done are not done again.
#SBATCH --cpus-per-task=4
#SBATCH --mem=2G
#SBATCH --time=02:00:00
#SBATCH --requeue
set -euo pipefail
manifest=$1 items=$2
if [ -n "${SLURM_ARRAY_TASK_ID:-}" ]; then
  exec exid fleet "$manifest" --items "$items" --threads "${SLURM_CPUS_PER_TASK:-1}" \
    --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
fi
exec exid fleet "$manifest" --items "$items" --threads "${SLURM_CPUS_PER_TASK:-1}"

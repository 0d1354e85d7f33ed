#!/usr/bin/env bash
# A fleet, or a campaign of trials, as an array of Slurm, and the whole when all of it is done:
#
#   sbatch --array=1-64 packaging/fleet/slurm.sh fleet nights.parquet --items /shared/items
#   sbatch --dependency=afterany:JOB packaging/fleet/slurm.sh fleet nights.parquet --items /shared/items
#
#   sbatch --array=1-64 packaging/fleet/slurm.sh trials --count 100000 --items /shared/trials
#
# Jobs may be killed, preempted and queued again: items that are done are not done again.
#SBATCH --cpus-per-task=4
#SBATCH --mem=2G
#SBATCH --time=02:00:00
#SBATCH --requeue
set -euo pipefail
part=()
if [ -n "${SLURM_ARRAY_TASK_ID:-}" ]; then
  part=(--shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT")
fi
exec exid "$@" --threads "${SLURM_CPUS_PER_TASK:-1}" "${part[@]}"

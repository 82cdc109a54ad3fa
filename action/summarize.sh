# Append what became of the pictures to the summary of the job.
#
# PICTURES: the folder of draw.sh. PUBLISHED_COMMIT: the commit of publish.sh, or nothing. ARTIFACT_URL: of the upload.
set -euo pipefail

bin=${GPU_XFORM_ENVIRONMENT:-$RUNNER_TEMP/gpu-xform}/bin
repository=$GITHUB_SERVER_URL/$GITHUB_REPOSITORY
published=
if [ -n "$PUBLISHED_COMMIT" ]; then
  published=$repository/raw/$PUBLISHED_COMMIT/$GITHUB_RUN_ID-$GITHUB_RUN_ATTEMPT-$GITHUB_JOB
fi
"$bin/python" "$GITHUB_ACTION_PATH/action/summary.py" write "$PICTURES/report.json" "$repository/raw/$GITHUB_SHA" \
  "$published" "$ARTIFACT_URL" >> "$GITHUB_STEP_SUMMARY"

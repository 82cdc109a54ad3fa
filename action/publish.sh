# Commit the pictures that someone should look at to a branch of their own, and output the commit.
#
# BRANCH: the name of the branch, which has no history in common with others. PICTURES: the folder of draw.sh. Without
# the permission to push, as in a pull request from a fork, there is a warning, and the summary has fewer thumbnails.
set -euo pipefail

bin=${GPU_XFORM_ENVIRONMENT:-$RUNNER_TEMP/gpu-xform}/bin
folder=$GITHUB_RUN_ID-$GITHUB_RUN_ATTEMPT-$GITHUB_JOB
staged=$RUNNER_TEMP/staged-pictures
rm -rf "$staged"
mkdir -p "$staged/$folder"
"$bin/python" "$GITHUB_ACTION_PATH/action/summary.py" stage "$PICTURES/report.json" "$staged/$folder"
if [ -z "$(ls -A "$staged/$folder")" ]; then
  exit 0
fi

export GIT_AUTHOR_NAME="github-actions[bot]" GIT_AUTHOR_EMAIL="41898282+github-actions[bot]@users.noreply.github.com"
export GIT_COMMITTER_NAME=$GIT_AUTHOR_NAME GIT_COMMITTER_EMAIL=$GIT_AUTHOR_EMAIL
export GIT_INDEX_FILE=$RUNNER_TEMP/pictures.index
for _ in 1 2 3 4 5; do # another job may push in between
  rm -f "$GIT_INDEX_FILE"
  parent=()
  if git fetch --quiet --depth=1 origin "refs/heads/$BRANCH" 2> /dev/null; then
    tip=$(git rev-parse FETCH_HEAD)
    parent=(-p "$tip")
    git read-tree "$tip"
  fi
  git --work-tree="$staged" add --force -- "$folder"
  commit=$(git commit-tree ${parent[@]+"${parent[@]}"} -m "Pictures of run $GITHUB_RUN_ID" "$(git write-tree)")
  if git push --quiet origin "$commit:refs/heads/$BRANCH"; then
    echo "commit=$commit" >> "$GITHUB_OUTPUT"
    exit 0
  fi
done
echo "::warning::the pictures could not be pushed to $BRANCH, which needs 'permissions: contents: write'"

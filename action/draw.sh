# Draw models and compare them with their references; the result is an output, so that later steps can report on it.
#
# MODELS: folders, patterns and files, one per line. REFERENCES: the path of a reference, or nothing. OPTIONS: further
# options, quoted as in a shell.
set -euo pipefail

bin=${GPU_XFORM_ENVIRONMENT:-$RUNNER_TEMP/gpu-xform}/bin
pictures=$RUNNER_TEMP/pictures-of-models
rm -rf "$pictures"
mkdir -p "$pictures"

paths=()
while IFS= read -r line; do
  [ -z "$line" ] || paths+=("$line")
done <<< "$MODELS"
split=$RUNNER_TEMP/words-of-options
"$bin/python" "$GITHUB_ACTION_PATH/action/split_words.py" "$OPTIONS" > "$split" # a failure ends the script
words=()
while IFS= read -r -d '' word; do
  words+=("$word")
done < "$split"

name="{folder}/{model}-{suffix}.png"
comparison=()
if [ -n "$REFERENCES" ]; then
  comparison=(--reference "$REFERENCES" --reference-diff "$pictures/differences/$name")
fi
code=0
"$bin/gpu-xform" render ${words[@]+"${words[@]}"} -o "$pictures/drawn/$name" ${comparison[@]+"${comparison[@]}"} \
  --report "$pictures/report.html" --report "$pictures/report.json" --report "$pictures/report.xml" \
  -- "${paths[@]}" || code=$?
{
  echo "exit-code=$code"
  echo "pictures=$pictures"
} >> "$GITHUB_OUTPUT"
if [ ! -f "$pictures/report.json" ]; then
  exit "$code" # wrong usage: there is nothing to report on
fi

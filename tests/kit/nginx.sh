#!/bin/sh
# Runs nginx with the configuration nginx.conf of a folder, in the foreground, until it is killed.
# nginx is installed by apt where it is missing, which needs the rights of root.
set -eu
folder=$1
if ! command -v nginx > /dev/null; then
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends nginx-light
fi
exec nginx -p "$folder" -c nginx.conf -e "$folder/error.log" -g 'daemon off;'

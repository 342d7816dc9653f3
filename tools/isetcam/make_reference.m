% Makes the reference values of crates/smalti/tests/data/isetcam with ISETCam under GNU Octave (packages image and statistics):
%
%   octave-cli -q make_reference.m ISETCAM DATA OUT [GROUP...]
%
% ISETCAM is a checkout of https://github.com/ISET/isetcam at ad5627536ef3. DATA is the folder above; it is only read, for
% inputs: filters, patterns, regions and exposure times. OUT is a new folder. The groups are scene, optics, sensor,
% processing, metrics and tiles; without names, all of them are made.
more off; warning('off', 'all');
pkg load image statistics
args = argv();
if numel(args) < 3, error('usage: make_reference.m ISETCAM DATA OUT [GROUP...]'); end
[isetcam, data, out] = args{1:3};
groups = args(4:end);
if isempty(groups), groups = {'scene', 'optics', 'sensor', 'processing', 'metrics', 'tiles'}; end
if strcmp(canonicalize_file_name(data), canonicalize_file_name(out)), error('OUT must not be DATA'); end
if ~exist(fullfile(out, 'spread'), 'dir'), mkdir(fullfile(out, 'spread')); end
here = fileparts(mfilename('fullpath'));
addpath(genpath(isetcam)); addpath(here); addpath(fullfile(here, 'octave'));
% ISETCam writes its preferences into the home folder, which should not change.
home = tempname(); mkdir(home); setenv('HOME', home);
ieInitSession; ieSessionSet('waitbar', 0);
for group = groups(:).'
  % Each group starts from the same seed, so that it gives the same numbers alone and among others.
  SEED = 20210514;
  rand('twister', SEED); randn('twister', SEED); randp('twister', SEED);
  begun = tic;
  feval(['make_' group{1}], data, out);
  printf('%s: %.0f s\n', group{1}, toc(begun));
end
confirm_recursive_rmdir(false); rmdir(home, 's');

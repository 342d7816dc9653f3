function [made, spread, mtf50] = edge_case(id, data, out, oi)
% The edge seen by one camera: MTF with and without noise. `mtf50` has all draws of a picture without noise; there is more
% than one with more than three colours only.
DRAWS = 10; NOISY_KEPT = 3;
held = read_json(data, ['ip_case_' id '.json']);
[filters, pattern] = reference_filters(id, data);
random = columns(filters) > 3;
rect = held.mtf.rect.';  % The same for all cameras.
sensor = camera(filters, pattern, held.bar_size(1), held.bar_size(2), held.bar_exp_time_s);
exposed = sensorCompute(sensor, oi);
draws = 1; if random, draws = DRAWS; end
curves = cell(1, draws); pictures = cell(1, draws);
for k = 1:draws, [curves{k}, pictures{k}] = edge_mtf(exposed, rect); end
mtf50 = cellfun(@(mtf) mtf.mtf50_exact, curves);
made = struct('bar_size', held.bar_size, 'bar_exp_time_s', held.bar_exp_time_s, 'mtf', setfield(curves{1}, 'rect', rect));
spread = struct();
for c = 1:3, write_csv(out, sprintf('bar_lrgb_%s_ch%d.csv', id, c), pictures{1}(:, :, c)); end
if random
  spread.mtf = deviation_of(curves);
  deviation = deviation_of(pictures);
  for c = 1:3, write_csv(fullfile(out, 'spread'), sprintf('bar_lrgb_%s_ch%d.csv', id, c), deviation(:, :, c)); end
else
  [made.mtf_autorect, made.ieISO12233_sensorspace] = found_region(exposed);
end

noisy = arrayfun(@(k) edge_mtf(sensorCompute(sensorSet(sensor, 'noise flag', 2), oi), rect).mtf50_exact, 1:DRAWS);
made.mtf_noise2 = noisy(1:NOISY_KEPT);
spread.mtf_noise2 = repmat(std(noisy), 1, NOISY_KEPT);
end

function [display, raw] = found_region(sensor)
% MTF in the region that ISETCam finds itself, of the picture in display RGB and of the demosaicked raw image. With more than
% three colours it often finds none, because the border of the picture is zero.
ip = ipCompute(ipCreate, sensor);
evalc('rect = ISOFindSlantedBar(ip);');  % It prints.
mtf = edge_mtf(sensor, rect);
display = struct('rect', rect, 'mtf50', mtf.mtf50, 'mtf50_exact', mtf.mtf50_exact);
evalc('found = ieISO12233(ip, sensor, ''none'');');
raw = struct('rect', found.rect, 'mtf50', found.mtf50, 'alias', found.aliasingPercentage);
end

function [made, spread] = chart_case(id, data, out, oi)
% The chart seen by one camera: exposure, colour matrices and the scores of its pictures with and without noise. With more
% than three colours, pictures without noise are random too: `made` has the first of some draws, `spread` their scatter.
DRAWS = 10; NOISY_KEPT = 3;
held = read_json(data, ['ip_case_' id '.json']);
[filters, pattern] = reference_filters(id, data);
random = columns(filters) > 3;
sensor = camera(filters, pattern, held.mac_size(1), held.mac_size(2), held.mac_exp_time_s);
exposed = sensorCompute(sensor, oi);
draws = 1; if random, draws = DRAWS; end
scores = cell(1, draws); matrices = cell(1, draws);
for k = 1:draws
  ip = ipCompute(ipCreate, exposed);
  scores{k} = score_chart(ip);
  matrices{k} = ipGet(ip, 'conversion transform sensor');  % ISETCam divides it by the largest value of the picture.
end
made = struct('mac_size', held.mac_size, 'mac_exp_time_s', held.mac_exp_time_s, ...
              'mac_max_volts', max(sensorGet(exposed, 'volts')(:)), 'T_sensor2xyz', matrices{1}, ...
              'M_xyz2display', ipGet(ip, 'ics2display'), 'mac_noisefree', scores{1});
spread = struct();
if random, spread = struct('T_sensor2xyz', deviation_of(matrices), 'mac_noisefree', deviation_of(scores)); end
if strcmp(id, 'nikonD100')
  planes = ipGet(ip, 'sensor space');
  for c = 1:3, write_csv(out, sprintf('ip_mac_demosaic_%s_ch%d.csv', id, c), planes(:, :, c)); end
  made.wb = struct('gray_world', balanced('gray world', exposed), 'white_world', balanced('white world', exposed));
end

noisy = cell(1, DRAWS);
for k = 1:DRAWS
  score = score_chart(ipCompute(ipCreate, sensorCompute(sensorSet(sensor, 'noise flag', 2), oi)));
  noisy{k} = struct('dE1976', score.sRGB.mean_dE1976, 'dE2000', score.sRGB.mean_dE2000, ...
                    'dE1976_custom', score.custom.mean_dE1976, 'lumnoise_pct', score.lumnoise_pct, ...
                    'lumnoise_mean', score.lumnoise_mean_pct);
end
deviation = deviation_of(noisy);
for key = fieldnames(deviation).'
  each = cellfun(@(score) score.(key{1}), noisy(1:NOISY_KEPT), 'UniformOutput', false);
  made.mac_noise2.(key{1}) = vertcat(each{:});
  spread.mac_noise2.(key{1}) = repmat(deviation.(key{1}), NOISY_KEPT, 1);
end
end

function score = balanced(method, sensor)
% White balance: its gains on X, Y, Z and the colour of the chart.
ip = ipCompute(ipSet(ipCreate, 'illuminant correction method', method), sensor);
chart = score_chart(ip);
score = struct('D', ipGet(ip, 'illuminant correction matrix'), 'lrgb', chart.lrgb, ...
               'mean_dE1976', chart.sRGB.mean_dE1976, 'mean_dE2000', chart.sRGB.mean_dE2000);
end

function sensor = camera(filters, pattern, rows, cols, exposure_s)
% The camera of the reference values: 2.8 um pixels, half of them sensitive, no noise. `filters` has one column per colour.
sensor = sensorCreate;
pixel = sensorGet(sensor, 'pixel');
pixel = pixelSet(pixel, 'size same fill factor', [2.8e-6 2.8e-6]);
pixel = pixelSet(pixel, 'fill factor', 0.5);
pixel = pixelSet(pixel, 'dark voltage', 1e-3);
pixel = pixelSet(pixel, 'read noise volts', 1e-3);
pixel = pixelSet(pixel, 'conversion gain', 1e-4);
pixel = pixelSet(pixel, 'voltage swing', 1);
pixel = pixelSet(pixel, 'spectral qe', ones(31, 1));
sensor = sensorSet(sensor, 'pixel', pixel);
sensor = sensorSet(sensor, 'dsnu sigma', 0);
sensor = sensorSet(sensor, 'prnu sigma', 0);
sensor = sensorSet(sensor, 'filter spectra', filters);
% ISETCam wants names that begin with one of its colour letters.
names = arrayfun(@(k) sprintf('k%d', k), 1:columns(filters), 'UniformOutput', false);
sensor = sensorSet(sensor, 'filter names', names);
sensor = sensorSet(sensor, 'pattern and size', pattern);
sensor = sensorSet(sensor, 'size', [rows cols]);
sensor = sensorSet(sensor, 'noise flag', 0);
if nargin > 4, sensor = sensorSet(sensor, 'exp time', exposure_s); end
end
